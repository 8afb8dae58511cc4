"""Trees, bushes, hedges."""

import numpy as np

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.outdoors.barriers import TALL_M
from footprints_edge_models.scenes.assets.things import (
    Thing,
    blob,
    cushion,
    foliage,
    joined,
    rectangle,
    rod,
)


def tree(palette: Palette) -> Thing:
    """A tree; only its trunk has a footprint."""
    rng = palette.rng
    tall = float(rng.uniform(3.5, 11))
    bark, leafage = palette.of("bark", tile_m=0.6), palette.leafage()
    trunk = float(rng.uniform(0.12, 0.3) + 0.015 * tall)
    bare = float(rng.uniform(0.25, 0.5)) * tall
    bare = max(bare, 1.6)
    parts = [rod(bark, (0, 0, -0.05), (0, 0, bare * 1.25), trunk, top=0.65, sides=9)]
    crown = tall * rng.uniform(0.3, 0.6)
    leafless = rng.random() < 0.15
    for _ in range(int(rng.integers(3, 7))):
        offset = rng.normal(0, 0.22, 3) * (crown, crown, (tall - bare) * 0.6)
        centre = np.array([0, 0, (bare + tall) / 2]) + offset
        parts.append(rod(bark, (0, 0, bare), centre, trunk * 0.5, top=0.3, sides=6))
        if leafless:
            for _ in range(6):
                tip = centre + rng.normal(0, 0.8, 3) + [0, 0, 0.5]
                parts.append(
                    rod(bark, centre * (0.6, 0.6, 1) - [0, 0, 0.3], tip, 0.05, top=0.3, sides=5)
                )
            continue
        size = np.array([crown, crown, (tall - bare) * 0.75]) * rng.uniform(0.6, 1)
        at = (centre[0], centre[1], max(centre[2] - size[2] / 2, bare * 0.75, 1.2))
        parts.append(foliage(leafage, size, at, int(rng.integers(100, 108)), 260, 0.16))
    return joined("tree", parts)


def conifer(palette: Palette) -> Thing:
    """A cypress or a fir with branches down to the ground."""
    rng = palette.rng
    tall, wide = float(rng.uniform(1.5, 6)), float(rng.uniform(0.7, 2.2))
    leafage = palette.leafage()
    parts = [rod(palette.of("bark"), (0, 0, 0), (0, 0, tall * 0.8), 0.15)]
    for index in range(4):
        share = 1 - index / 4.5
        parts.append(
            foliage(
                leafage,
                (wide * share, wide * share, tall * 0.42),
                (0, 0, tall * index * 0.19),
                110 + index,
                200,
                0.15,
            )
        )
    return joined("tree", parts)


def bush(palette: Palette) -> Thing:
    """A bush."""
    rng = palette.rng
    size = rng.uniform(0.5, 2.0, 3) * (1, 1, 0.7)
    parts = [
        foliage(
            palette.leafage(), size, (0, 0, -0.1 * size[2]), int(rng.integers(120, 126)), 300, 0.14
        )
    ]
    core = Material(palette.leafage().texture, 0.4, (0.5, 0.5, 0.5))
    parts.append(blob(core, size * 0.75, (0, 0, 0)))
    return joined("bush", parts)


def hedge(palette: Palette, length_m: float) -> Thing:
    """A clipped hedge along x."""
    rng = palette.rng
    deep, tall = float(rng.uniform(0.4, 0.8)), float(rng.uniform(0.5, 2.0))
    leafage = palette.leafage()
    parts = [cushion(leafage, (length_m, deep, tall), (0, 0, 0), squareness=0.1)]
    count = max(1, round(length_m / 1.2))
    for index in range(count):
        x = (index + 0.5 - count / 2) * length_m / count
        parts.append(
            foliage(leafage, (1.7, deep * 1.25, tall * 1.1), (x, 0, 0), 120 + index % 6, 300, 0.1)
        )
    outline = rectangle(-length_m / 2, -deep / 2, length_m / 2, deep / 2)
    return joined("hedge", parts, outlines=(outline,), is_wall=tall >= TALL_M)
