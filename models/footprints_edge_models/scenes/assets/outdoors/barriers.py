"""Fences, garden walls, guard rails."""

import numpy as np

from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.things import Thing, ThingPart, box, joined, rectangle

TALL_M = 1.2
"""Hedges, board fences and garden walls from this height on hide the ground behind as houses do."""


def fence(palette: Palette, length_m: float) -> Thing:
    """A fence along x: boards, pickets, bars, rails or wire."""
    rng = palette.rng
    tall = float(rng.uniform(0.7, 2.0))
    made = palette.of("wood", "planks", "plaster", "metal", "paint", tile_m=0.7)
    style = rng.integers(4)
    parts: list[ThingPart] = []
    posts = max(2, round(length_m / 2.2) + 1)
    parts += [
        box(made, (0.09, 0.09, tall + 0.05), (x, 0, 0))
        for x in np.linspace(-length_m / 2, length_m / 2, posts)
    ]
    if style == 0:
        parts.append(box(made, (length_m, 0.03, tall - 0.05), (0, 0, 0.05)))
    else:
        rails = (0.18, 0.85) if style != 3 else (0.3, 0.6, 0.9)
        parts += [box(made, (length_m, 0.04, 0.07), (0, 0, tall * share)) for share in rails]
        if style != 3:
            wide, gap = (0.08, 0.15) if style == 1 else (0.02, 0.12)
            parts += [
                box(made, (wide, 0.025, tall), (x, -0.03, 0.05))
                for x in np.arange(-length_m / 2, length_m / 2, gap)
            ]
    outline = rectangle(-length_m / 2, -0.06, length_m / 2, 0.06)
    is_wall = style == 0 and tall >= TALL_M
    return joined("fence", parts, outlines=(outline,), is_wall=is_wall)


def garden_wall(palette: Palette, length_m: float) -> Thing:
    """A wall along x."""
    rng = palette.rng
    tall = float(rng.uniform(0.4, 2.4))
    made = palette.of("bricks", "plaster", "concrete", "paving", tile_m=(0.8, 1.6))
    parts = [box(made, (length_m, 0.25, tall), (0, 0, 0))]
    parts.append(box(palette.of("concrete", "plaster"), (length_m, 0.33, 0.07), (0, 0, tall)))
    return joined("wall", parts, is_wall=tall >= TALL_M)


def barrier(palette: Palette, length_m: float) -> Thing:
    """A guard rail or concrete blocks."""
    rng = palette.rng
    if rng.random() < 0.5:
        metal = palette.of("metal", gloss=0.1)
        parts = [box(metal, (length_m, 0.06, 0.3), (0, 0, 0.45))]
        parts += [
            box(metal, (0.1, 0.1, 0.7), (x, 0.06, 0))
            for x in np.arange(-length_m / 2, length_m / 2 + 0.1, 2.0)
        ]
        return joined(
            "barrier", parts, outlines=(rectangle(-length_m / 2, -0.1, length_m / 2, 0.15),)
        )
    first, second = palette.of("concrete", "plaster"), palette.of("plain", "concrete", "paint")
    parts = []
    for index, x in enumerate(np.arange(-length_m / 2, length_m / 2, 1.0)):
        parts.append(box((first, second)[index % 2], (0.98, 0.4, 0.75), (x + 0.5, 0, 0)))
    return joined("barrier", parts)
