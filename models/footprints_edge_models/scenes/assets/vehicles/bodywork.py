"""Parts that vehicles share: hulls, wheels, the ground they cover."""

import numpy as np

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.shapes import loft
from footprints_edge_models.scenes.assets.things import ThingPart, disc_on_side

_Profile = list[tuple[float, float]]


def hull(
    material: Material, profile: _Profile, widths: tuple[float, float], round_m: float
) -> ThingPart:
    """A side view (y, z), extruded across x; ``widths`` at its foot and its top, rounded edges."""
    points = np.array(profile)
    low, high = points[:, 1].min(), points[:, 1].max()
    half = np.interp(points[:, 1], [low, high], widths) / 2
    centre = points.mean(axis=0)
    inner = (
        centre
        + (points - centre) * (1 - round_m / np.linalg.norm(points - centre, axis=1))[:, None]
    )
    rings = []
    for sign, outline, inset in (
        (-1, inner, 0.0),
        (-1, points, 0.05),
        (1, points, 0.05),
        (1, inner, 0.0),
    ):
        rings.append(np.column_stack([sign * (half - inset), outline]))
    # rings run along +x: counter-clockwise from +x is (y, z) counter-clockwise
    return ThingPart(loft(rings), np.eye(3, 4), material)


def wheels(
    palette: Palette, track_m: float, axles: list[float], diameter_m: float
) -> list[ThingPart]:
    """Tyres, rims and wheel arches at both ends of each axle."""
    tyre, rim = palette.dark(), palette.of("metal", "plain", gloss=0.1)
    parts = []
    for y in axles:
        for side in (-1, 1):
            x = side * (track_m / 2 - 0.1)
            hub = (x, y, diameter_m / 2)
            parts.append(disc_on_side(tyre, diameter_m, 0.21, hub))
            parts.append(disc_on_side(rim, diameter_m * 0.62, 0.225, hub, sides=10))
            arch = (side * (track_m / 2 - 0.115), y, diameter_m / 2 + 0.02)
            parts.append(disc_on_side(tyre, diameter_m * 1.17, 0.235, arch, sides=14))
    return parts


def outline_of(
    width_m: float, length_m: float
) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """A rectangle with its corners cut."""
    x, y, cut = width_m / 2, length_m / 2, min(0.2, width_m / 5)
    return np.array(
        [
            (x - cut, -y),
            (x, -y + cut),
            (x, y - cut),
            (x - cut, y),
            (-x + cut, y),
            (-x, y - cut),
            (-x, -y + cut),
            (-x + cut, -y),
        ]
    )
