"""Bicycles and motorbikes, standing or ridden."""

from itertools import pairwise

import numpy as np

from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.people import rider_parts
from footprints_edge_models.scenes.assets.things import (
    Thing,
    ThingPart,
    box,
    cushion,
    disc_on_side,
    joined,
    rectangle,
    rod,
    shifted,
)


def _spokes(palette: Palette, y: float, diameter_m: float, thick_m: float) -> list[ThingPart]:
    tyre, metal = palette.dark(), palette.metal()
    angles = np.linspace(0, 2 * np.pi, 19)
    rim = np.column_stack(
        [
            np.zeros(19),
            y + diameter_m / 2 * 0.95 * np.cos(angles),
            diameter_m / 2 * (1 + 0.95 * np.sin(angles)),
        ]
    )
    hub = (0, y, diameter_m / 2)
    spokes = [rod(metal, start, hub, 0.012, sides=4) for start in rim[:-1:3]]
    return spokes + [rod(tyre, start, end, thick_m, sides=6) for start, end in pairwise(rim)]


def bicycle(palette: Palette, *, ridden: bool) -> Thing:
    """A bicycle, standing or ridden."""
    rng = palette.rng
    frame = palette.of("paint", "plain", gloss=0.1)
    dark = palette.dark()
    wheel = 0.68
    parts = _spokes(palette, -0.52, wheel, 0.045) + _spokes(palette, 0.52, wheel, 0.045)
    crank, seat, head = (0, 0.08, 0.3), (0, 0.22, 0.85), (0, -0.38, 0.82)
    hubs = ((0, -0.52, wheel / 2), (0, 0.52, wheel / 2))
    for start, end in (
        (crank, seat),
        (crank, head),
        (seat, head),
        (seat, hubs[1]),
        (crank, hubs[1]),
        (head, hubs[0]),
    ):
        parts.append(rod(frame, start, end, 0.04, sides=6))
    parts.append(rod(dark, head, (0, -0.36, 1.0), 0.035, sides=6))
    parts.append(rod(dark, (-0.28, -0.34, 1.02), (0.28, -0.34, 1.02), 0.035, sides=6))
    parts.append(cushion(dark, (0.15, 0.27, 0.07), (0, 0.22, 0.86), squareness=0.6))
    if rng.random() < 0.3:
        parts.append(box(palette.cloth(), (0.35, 0.3, 0.3), (0, 0.6, 0.72)))
    if ridden:
        parts += shifted(rider_parts(palette, 0.9, (-0.52, 1.05)), 0, 0.2)
    return joined("bicycle", parts, outlines=(rectangle(-0.2, -0.86, 0.2, 0.86),))


def motorbike(palette: Palette, *, ridden: bool) -> Thing:
    """A motorbike or a scooter, standing or ridden."""
    rng = palette.rng
    paint, dark = palette.of("paint", "plain", gloss=0.12), palette.dark()
    wheel = float(rng.choice([0.45, 0.62]))
    parts = []
    for y in (-0.6, 0.6):
        parts.append(disc_on_side(dark, wheel, 0.12, (0, y, wheel / 2)))
        parts.append(disc_on_side(palette.metal(), wheel * 0.6, 0.13, (0, y, wheel / 2), sides=10))
        parts.append(cushion(paint, (0.16, 0.5, 0.12), (0, y, wheel * 0.95), squareness=0.6))
    parts.append(cushion(palette.metal(), (0.3, 0.5, 0.35), (0, 0.02, 0.28), squareness=0.4))
    parts.append(cushion(paint, (0.3, 0.6, 0.28), (0, -0.12, 0.62), squareness=0.6))
    parts.append(cushion(dark, (0.28, 0.75, 0.12), (0, 0.35, 0.74), squareness=0.5))
    parts.append(rod(dark, (0, -0.6, wheel / 2), (0, -0.42, 1.0), 0.07))
    parts.append(rod(dark, (-0.36, -0.38, 1.02), (0.36, -0.38, 1.02), 0.04))
    parts.append(cushion(paint, (0.22, 0.16, 0.2), (0, -0.55, 0.82), squareness=0.6))
    if rng.random() < 0.4:
        parts.append(cushion(paint, (0.4, 0.12, 0.55), (0, -0.4, 0.3), squareness=0.4))
    if ridden:
        parts += shifted(rider_parts(palette, 0.82, (-0.62, 1.02)), 0, 0.2)
        if rng.random() < 0.25:
            parts += shifted(rider_parts(palette, 0.84, (-0.3, 1.1)), 0, 0.52)
    return joined("motorbike", parts, outlines=(rectangle(-0.3, -0.88, 0.3, 0.88),))
