"""Poles, signs, benches, bins."""

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.things import (
    Thing,
    blob,
    box,
    column,
    foliage,
    joined,
    rod,
)


def pole(palette: Palette) -> Thing:
    """A lamp post, a traffic light, a sign, a telegraph pole, a bollard."""
    rng = palette.rng
    metal = palette.of("metal", "paint", "concrete", gloss=0.05)
    style = rng.integers(5)
    if style == 0:
        tall = float(rng.uniform(4.5, 9))
        parts = [
            rod(metal, (0, 0, 0), (0, 0, tall), 0.16, top=0.6),
            column(metal, 0.24, 0.6, (0, 0, 0)),
        ]
        parts.append(rod(metal, (0, 0, tall), (0, -1.4, tall + 0.25), 0.08))
        parts.append(box(metal, (0.2, 0.6, 0.1), (0, -1.6, tall + 0.2)))
        return joined("lamp post", parts)
    if style == 1:
        parts = [
            column(metal, 0.12, 3.3, (0, 0, 0)),
            box(palette.dark(), (0.32, 0.25, 0.9), (0, -0.15, 2.3)),
        ]
        for index, colour in enumerate(((0.1, 0.5, 0.2), (0.6, 0.45, 0.1), (0.8, 0.1, 0.1))):
            lamp = Material(
                palette.of("blank").texture, 1.0, colour, glow=float(rng.choice([0, 1]))
            )
            parts.append(blob(lamp, (0.2, 0.06, 0.2), (0, -0.28, 2.38 + 0.27 * index)))
        return joined("traffic light", parts)
    if style == 2:
        tall = float(rng.uniform(1.8, 3))
        face = palette.of("print", "plain", "paint", tile_m=0.7)
        parts = [column(metal, 0.07, tall, (0, 0, 0))]
        if rng.random() < 0.5:
            parts.append(rod(face, (0, -0.05, tall - 0.3), (0, -0.08, tall - 0.3), 0.6, sides=18))
        else:
            parts.append(
                box(
                    face, (rng.uniform(0.4, 1), 0.03, rng.uniform(0.3, 0.8)), (0, -0.06, tall - 0.6)
                )
            )
        return joined("sign", parts)
    if style == 3:
        tall = float(rng.uniform(6, 9))
        wood = palette.of("bark", "concrete", "wood")
        parts = [
            rod(wood, (0, 0, 0), (0, 0, tall), 0.26, top=0.7),
            box(wood, (1.8, 0.1, 0.12), (0, 0, tall - 0.6)),
        ]
        return joined("pole", parts)
    parts = [column(metal, 0.14, rng.uniform(0.7, 1.1), (0, 0, 0))]
    return joined("bollard", parts)


def bench(palette: Palette) -> Thing:
    """A bench."""
    rng = palette.rng
    wood, metal = palette.wood(), palette.metal()
    wide = float(rng.uniform(1.3, 2.0))
    parts = [box(wood, (wide, 0.12, 0.04), (0, y, 0.43)) for y in (-0.2, -0.05, 0.1)]
    if rng.random() < 0.7:
        parts += [box(wood, (wide, 0.03, 0.12), (0, 0.22, z)) for z in (0.55, 0.73)]
    for side in (-1, 1):
        x = side * wide * 0.42
        parts.append(box(metal, (0.06, 0.06, 0.43), (x, -0.2, 0)))
        parts.append(box(metal, (0.06, 0.06, 0.85), (x, 0.19, 0)))
        parts.append(box(metal, (0.06, 0.45, 0.05), (x, 0, 0.38)))
    return joined("bench", parts)


def street_bin(palette: Palette) -> Thing:
    """A litter bin, a wheeled bin, a letter box, a cabinet, a planter."""
    rng = palette.rng
    style = rng.integers(4)
    made = palette.of("plain", "paint", "metal", gloss=0.05)
    if style == 0:
        return joined(
            "bin",
            [column(made, 0.45, 0.9, (0, 0, 0)), column(palette.dark(), 0.47, 0.08, (0, 0, 0.9))],
        )
    if style == 1:
        parts = [
            box(made, (0.55, 0.6, 0.95), (0, 0, 0.08)),
            box(made, (0.6, 0.68, 0.06), (0, 0, 1.03), 0, 0.05),
        ]
        parts += [box(palette.dark(), (0.08, 0.2, 0.2), (sx * 0.25, 0.25, 0)) for sx in (-1, 1)]
        return joined("bin", parts)
    if style == 2:
        return joined(
            "cabinet", [box(made, (rng.uniform(0.5, 1.2), 0.4, rng.uniform(0.9, 1.6)), (0, 0, 0))]
        )
    tub = palette.of("concrete", "wood", "plaster")
    wide = float(rng.uniform(0.5, 1.2))
    parts = [box(tub, (wide, wide, 0.5), (0, 0, 0))]
    parts.append(
        foliage(palette.leafage(), (wide * 1.1, wide * 1.1, 0.8), (0, 0, 0.3), 121, 420, 0.12)
    )
    return joined("planter", parts)
