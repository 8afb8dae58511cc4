"""Barrows and stalls."""

from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.things import (
    Thing,
    box,
    column,
    cushion,
    disc_on_side,
    joined,
    rectangle,
)


def cart(palette: Palette) -> Thing:
    """A barrow or a stall."""
    rng = palette.rng
    wood, cloth = palette.main_wood(), palette.cloth()
    wide, long_ = float(rng.uniform(0.9, 1.4)), float(rng.uniform(1.5, 2.2))
    parts = [box(wood, (wide, long_, 0.12), (0, 0, 0.75))]
    for side in (-1, 1):
        parts.append(disc_on_side(palette.dark(), 0.6, 0.06, (side * wide / 2, 0, 0.3)))
        parts += [
            column(wood, 0.06, 2.1, (side * (wide / 2 - 0.05), end * (long_ / 2 - 0.1), 0))
            for end in (-1, 1)
        ]
    parts.append(box(cloth, (wide + 0.4, long_ + 0.4, 0.06), (0, 0, 2.1)))
    for _ in range(12):
        x, y = (rng.random(2) - 0.5) * (wide, long_) * 0.8
        parts.append(
            cushion(palette.of("plain", value=0.2), (0.3, 0.3, 0.25), (x, y, 0.87), squareness=0.7)
        )
    return joined("stall", parts, outlines=(rectangle(-wide / 2, -long_ / 2, wide / 2, long_ / 2),))
