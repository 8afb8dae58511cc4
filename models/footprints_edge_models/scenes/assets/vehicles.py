"""Cars, vans, buses, lorries, motorbikes, bicycles. Their noses look along -y.

The ground below a vehicle cannot be walked on: it takes its whole outline.
"""

from itertools import pairwise

import numpy as np

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.people import rider_parts
from footprints_edge_models.scenes.assets.shapes import loft
from footprints_edge_models.scenes.assets.things import (
    Part,
    Thing,
    box,
    column,
    cushion,
    disc_on_side,
    joined,
    rectangle,
    rod,
    shifted,
)

_Profile = list[tuple[float, float]]


def _hull(
    material: Material, profile: _Profile, widths: tuple[float, float], round_m: float
) -> Part:
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
    return Part(loft(rings), np.eye(3, 4), material)


def _wheels(palette: Palette, track_m: float, axles: list[float], diameter_m: float) -> list[Part]:
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


def car(palette: Palette) -> Thing:
    """A saloon, a hatchback, an estate, an off-roader, a van or a three-wheeled taxi."""
    rng = palette.rng
    paint = palette.of("paint", "paint", "plain", gloss=0.12, sharpness=0.8)
    style = rng.choice(
        ["saloon", "hatch", "estate", "suv", "van", "taxi"], p=[0.26, 0.28, 0.12, 0.16, 0.12, 0.06]
    )
    size = float(rng.normal(1, 0.04))
    length, width, height = {
        "saloon": (4.5, 1.78, 1.45), "hatch": (3.9, 1.7, 1.5), "estate": (4.6, 1.8, 1.5),
        "suv": (4.4, 1.85, 1.72), "van": (4.9, 1.95, 2.1), "taxi": (2.7, 1.3, 1.75),
    }[style]  # fmt: skip
    length, width, height = length * size, width * size, height * size
    front, back = -length / 2, length / 2
    clear = 0.28 if style == "suv" else 0.2
    belt = height * (0.62 if style != "van" else 0.55)
    nose = front + length * (0.27 if style not in {"van", "taxi"} else 0.12)
    tail = {"saloon": back - length * 0.17}.get(str(style), back - 0.06)
    body = [
        (front + 0.02, clear), (back - 0.02, clear), (back, belt * 0.6), (back - 0.05, belt * 0.97),
        (tail, belt), (nose, belt), (front + length * 0.05, belt * 0.8), (front, belt * 0.62),
    ]  # fmt: skip
    parts = [_hull(paint, body, (width * 0.97, width * 0.98), 0.1)]
    slope = {"saloon": 0.45, "hatch": 0.4, "estate": 0.12, "suv": 0.2, "van": 0.04, "taxi": 0.1}[
        str(style)
    ]
    rake = 0.55 if style not in {"van", "taxi"} else 0.4
    roof_front, roof_back = (
        nose + (height - belt) * rake * 1.7,
        tail - slope * (height - belt) * 1.7,
    )
    glass = palette.glass()
    cabin = [(nose, belt - 0.02), (tail, belt - 0.02), (roof_back, height), (roof_front, height)]
    parts.append(
        _hull(
            glass if style != "taxi" else palette.of("paint", "fabric"),
            cabin,
            (width * 0.95, width * 0.74),
            0.06,
        )
    )
    top = width * 0.76
    roof = [
        (roof_front - 0.04, height - 0.07), (roof_back + 0.04, height - 0.07),
        (roof_back - 0.12, height + 0.02), (roof_front + 0.12, height + 0.02),
    ]  # fmt: skip
    parts.append(_hull(paint, roof, (top + 0.03, top - 0.06), 0.03))
    half_low, half_high = width * 0.475, width * 0.375
    middle = (nose + tail) / 2 - 0.1
    for side in (-1, 1):
        for low, high in (
            ((nose, belt), (roof_front, height)),
            ((tail, belt), (roof_back, height)),
            ((middle, belt), (middle, height)),
        ):
            parts.append(
                rod(
                    paint,
                    (side * half_low, low[0], low[1] - 0.02),
                    (side * half_high, high[0], high[1] - 0.02),
                    0.075,
                    sides=6,
                )
            )
        if style == "van" and rng.random() < 0.6:
            panel = [
                (middle, belt),
                (tail, belt),
                (roof_back, height - 0.1),
                (middle, height - 0.1),
            ]
            parts.append(
                shifted([_hull(paint, panel, (width * 0.96, width * 0.78), 0.02)], 0, 0)[0]
            )
        parts.append(cushion(paint, (0.2, 0.1, 0.13), (side * (half_low + 0.1), nose + 0.25, belt)))
        lamp = palette.of("plaster", gloss=0.3)
        parts.append(
            box(lamp, (0.32, 0.06, 0.12), (side * (width / 2 - 0.24), front + 0.02, belt * 0.66))
        )
        red = Material(palette.of("blank").texture, 1.0, (0.75, 0.08, 0.06), 0.1)
        parts.append(
            box(red, (0.2, 0.05, 0.2), (side * (width / 2 - 0.17), back - 0.02, belt * 0.7))
        )
        handle = (side * width * 0.485, middle + 0.25, belt - 0.12)
        parts.append(box(palette.dark(), (0.03, 0.16, 0.03), handle))
    dark = palette.dark()
    parts.append(box(dark, (width * 0.5, 0.05, 0.14), (0, front - 0.0, belt * 0.45)))
    parts.append(box(dark, (width * 0.9, length * 0.98, 0.1), (0, 0, clear - 0.03)))
    plate = palette.of("plaster", "plain")
    parts += [box(plate, (0.5, 0.04, 0.11), (0, y, belt * 0.42)) for y in (front - 0.02, back)]
    wheel = (0.62 if style != "suv" else 0.72) * size if style != "taxi" else 0.42
    parts += _wheels(palette, width, [front + length * 0.19, back - length * 0.2], wheel)
    return joined("car" if style != "van" else "van", parts, outlines=(_outline(width, length),))


def _outline(width_m: float, length_m: float) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
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


def bus(palette: Palette) -> Thing:
    """A bus or a lorry."""
    rng = palette.rng
    paint = palette.of("paint", "plain", "photo", tile_m=3.0, gloss=0.1)
    lorry = rng.random() < 0.5
    length, width = float(rng.uniform(6, 11)), float(rng.uniform(2.2, 2.5))
    height = float(rng.uniform(2.6, 3.4))
    front, back = -length / 2, length / 2
    glass, dark = palette.glass(), palette.dark()
    clear = 0.35
    if lorry:
        cab = 1.7
        parts = [
            _hull(
                paint,
                [
                    (front, clear),
                    (front + cab, clear),
                    (front + cab, height * 0.85),
                    (front + 0.25, height * 0.85),
                    (front, height * 0.5),
                ],
                (width, width * 0.94),
                0.08,
            ),
            box(dark, (width * 0.8, length * 0.98, 0.25), (0, 0.05, 0.55)),
        ]
        parts.append(
            box(
                glass,
                (width * 0.88, 0.06, height * 0.24),
                (0, front + 0.11, height * 0.52),
                0,
                -0.25,
            )
        )
        load = palette.of("plain", "metal", "siding", "wood", "paint", tile_m=(1.0, 3.0))
        parts.append(
            box(
                load,
                (width, length - cab - 0.15, height - 0.8 if rng.random() < 0.7 else 0.9),
                (0, (cab + 0.1) / 2, 0.8),
            )
        )
    else:
        parts = [
            _hull(
                paint,
                [
                    (front, clear),
                    (back, clear),
                    (back, height),
                    (front + 0.15, height),
                    (front, height * 0.55),
                ],
                (width, width * 0.97),
                0.08,
            ),
            box(
                glass,
                (width * 0.9, 0.05, height * 0.42),
                (0, front + 0.02, height * 0.42),
                0,
                -0.05,
            ),
            box(glass, (width * 0.8, 0.05, height * 0.28), (0, back, height * 0.6)),
        ]
        count = int(length / 1.3)
        for index in range(count):
            y = front + 0.9 + index * (length - 1.4) / count
            parts.append(
                box(
                    glass,
                    (width + 0.01, (length - 1.4) / count * 0.86, height * 0.32),
                    (0, y, height * 0.52),
                )
            )
        band = palette.of("paint", "plain")
        parts.append(box(band, (width + 0.012, length * 0.99, 0.25), (0, 0, height * 0.3)))
    for side in (-1, 1):
        parts.append(
            box(
                palette.of("plaster", gloss=0.3),
                (0.3, 0.06, 0.2),
                (side * width * 0.38, front, 0.65),
            )
        )
        red = Material(palette.of("blank").texture, 1.0, (0.75, 0.08, 0.06), 0.1)
        parts.append(box(red, (0.2, 0.05, 0.3), (side * width * 0.42, back, 0.7)))
    parts += _wheels(palette, width, [front + length * 0.17, back - length * 0.24], 0.95)
    return joined("lorry" if lorry else "bus", parts, outlines=(_outline(width, length),))


def _spokes(palette: Palette, y: float, diameter_m: float, thick_m: float) -> list[Part]:
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
