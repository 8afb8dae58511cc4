"""Houses."""

import numpy as np

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.things import Thing, ThingPart, box, joined, rectangle


def house(
    palette: Palette, width_m: float, depth_m: float, height_m: float, *, shop: bool
) -> Thing:
    """A house whose front looks along -y from y = 0; it reaches back to y = depth_m."""
    rng = palette.rng
    wall = palette.of(
        "bricks", "plaster", "plaster", "siding", "concrete", "paving", tile_m=(1.2, 3.0)
    )
    trim, glass = palette.of("plaster", "concrete", "wood"), palette.glass()
    parts = [box(wall, (width_m, depth_m, height_m), (0, depth_m / 2, 0))]
    storey = float(rng.uniform(2.7, 3.6))
    storeys = max(1, int(height_m / storey))
    columns = max(1, round(width_m / rng.uniform(2.0, 3.6)))
    wide, tall = float(rng.uniform(0.8, 1.6)), float(rng.uniform(1.1, 1.8))
    door_column = int(rng.integers(columns))
    style = rng.random()
    for floor in range(storeys):
        for index in range(columns):
            x = (index + 0.5) * width_m / columns - width_m / 2
            z = floor * storey + 0.95
            if floor == 0 and shop:
                if index == 0:
                    front = (
                        palette.of("photo", "print", "plain", tile_m=2.5)
                        if rng.random() < 0.4
                        else glass
                    )
                    parts.append(box(front, (width_m * 0.9, 0.06, 2.1), (0, -0.02, 0.35)))
                    sign = palette.of("print", "plain", "paint", "photo", tile_m=2.0)
                    parts.append(box(sign, (width_m * 0.95, 0.15, 0.6), (0, -0.06, 2.55)))
                    if rng.random() < 0.4:
                        parts.append(
                            box(
                                palette.cloth(), (width_m * 0.9, 1.2, 0.06), (0, -0.6, 2.5), 0, 0.25
                            )
                        )
                continue
            if floor == 0 and index == door_column:
                leaf = palette.of("wood", "plain", "paint", "metal")
                parts.append(box(trim, (1.2, 0.08, 2.25), (x, -0.01, 0)))
                parts.append(box(leaf, (0.95, 0.06, 2.1), (x, -0.05, 0)))
                continue
            parts.append(box(trim, (wide + 0.2, 0.06, tall + 0.2), (x, -0.01, z - 0.1)))
            parts.append(box(glass, (wide, 0.04, tall), (x, -0.03, z)))
            if style < 0.6:
                parts.append(box(trim, (0.06, 0.05, tall), (x, -0.04, z)))
                parts.append(box(trim, (wide, 0.05, 0.06), (x, -0.04, z + tall / 2)))
            parts.append(box(trim, (wide + 0.3, 0.2, 0.08), (x, -0.06, z - 0.14)))
            if style > 0.85 and floor:
                parts.append(box(palette.metal(), (wide + 0.8, 0.9, 0.12), (x, -0.45, z - 0.9)))
                parts.append(box(palette.metal(), (wide + 0.8, 0.04, 0.9), (x, -0.88, z - 0.8)))
    if rng.random() < 0.5:
        parts.append(box(trim, (width_m, 0.3, 0.25), (0, -0.06, height_m - 0.25)))
    if rng.random() < 0.4:
        parts.append(box(palette.of("concrete", "paving"), (width_m, 0.08, 0.5), (0, -0.02, 0)))
    if height_m < 8 and rng.random() < 0.8:
        roof = palette.of("tiles", "bricks", "concrete", "siding", tile_m=(0.8, 2.0), value=0.2)
        rise = float(rng.uniform(0.25, 0.6)) * depth_m / 2
        parts.append(_gable(roof, width_m + 0.6, depth_m + 0.9, rise, height_m))
    if rng.random() < 0.3 and height_m < 9:
        garage = palette.of("siding", "plain", "plaster", tile_m=2.0)
        parts.append(box(garage, (2.6, 0.06, 2.2), (width_m / 2 - 1.7, -0.04, 0)))
    outline = rectangle(-width_m / 2, 0, width_m / 2, depth_m)
    return joined("building", parts, outlines=(outline,), is_wall=True)


def _gable(
    material: Material, width_m: float, depth_m: float, rise_m: float, z: float
) -> ThingPart:
    from footprints_edge_models.scenes.assets.shapes import loft

    profile = np.array([(-0.45, 0), (depth_m - 0.45, 0), (depth_m / 2 - 0.45, rise_m)])
    rings = [
        np.column_stack([np.full(3, x), profile + np.array((0, z))])
        for x in (-width_m / 2, width_m / 2)
    ]
    return ThingPart(loft(rings), np.eye(3, 4), material)
