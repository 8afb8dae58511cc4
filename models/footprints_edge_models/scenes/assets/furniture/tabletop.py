"""Small things on a surface: books, cups, papers, bottles."""

from footprints_edge_models.scenes.assets.furniture.plants import potted
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.things import ThingPart, blob, box, column, shifted


def on_top(
    palette: Palette, width_m: float, depth_m: float, z: float, count: float
) -> list[ThingPart]:
    """Small things on a surface: books, boxes, cups, bowls, papers, plants, bottles."""
    rng = palette.rng
    parts: list[ThingPart] = []
    for _ in range(rng.poisson(count)):
        x, y = (rng.random(2) - 0.5) * (width_m, depth_m)
        yaw = float(rng.uniform(-3, 3))
        dice = rng.random()
        if dice < 0.3:
            for layer in range(int(rng.integers(1, 4))):
                cover = palette.of("print", "plain", "photo", tile_m=0.25, value=0.2)
                size = (rng.uniform(0.13, 0.24), rng.uniform(0.18, 0.32), 0.025)
                parts.append(box(cover, size, (x, y, z + layer * 0.025), yaw + layer * 0.2))
        elif dice < 0.45:
            paper = palette.of("print", "plaster", tile_m=0.3)
            parts.append(box(paper, (0.21, 0.297, 0.004), (x, y, z), yaw))
        elif dice < 0.62:
            cup = palette.of("plain", "plaster", gloss=0.08)
            wide = float(rng.uniform(0.06, 0.11))
            parts.append(column(cup, wide, rng.uniform(0.07, 0.13), (x, y, z), top=1.15, sides=10))
        elif dice < 0.72:
            bottle = palette.of("plain", "metal", gloss=0.15)
            parts.append(column(bottle, 0.075, 0.18, (x, y, z), sides=10))
            parts.append(column(bottle, 0.03, 0.09, (x, y, z + 0.18), sides=8))
        elif dice < 0.84:
            carton = palette.of("print", "plain", "photo", "wood", tile_m=0.4)
            parts.append(box(carton, rng.uniform(0.08, 0.35, 3) * (1, 1, 0.7), (x, y, z), yaw))
        elif dice < 0.92:
            bowl = palette.of("plain", "wood", "metal", gloss=0.08)
            parts.append(column(bowl, 0.14, 0.09, (x, y, z), top=1.7, sides=12))
            for _ in range(int(rng.integers(0, 6))):
                fruit = palette.of("plain", value=0.2)
                dx, dy = rng.normal(0, 0.05, 2)
                parts.append(blob(fruit, (0.08, 0.08, 0.08), (x + dx, y + dy, z + 0.06)))
        else:
            parts += shifted(potted(palette, float(rng.uniform(0.15, 0.45))), x, y, z)
    return parts
