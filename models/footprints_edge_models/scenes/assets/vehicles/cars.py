"""Cars, vans and three-wheeled taxis."""

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.models import or_model
from footprints_edge_models.scenes.assets.things import Thing, box, cushion, joined, rod, shifted
from footprints_edge_models.scenes.assets.vehicles.bodywork import hull, outline_of, wheels


@or_model(
    "hatchback",
    "sedan",
    "suv",
    "taxi",
    "police",
    "prius",
    "pickup",
    "chevrolet",
    "peugeot",
    "renault",
    "seat leon",
    "smart car",
    "beetle",
    " van ",
    "ambulance",
)
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
    parts = [hull(paint, body, (width * 0.97, width * 0.98), 0.1)]
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
        hull(
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
    parts.append(hull(paint, roof, (top + 0.03, top - 0.06), 0.03))
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
            parts.append(shifted([hull(paint, panel, (width * 0.96, width * 0.78), 0.02)], 0, 0)[0])
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
    parts += wheels(palette, width, [front + length * 0.19, back - length * 0.2], wheel)
    return joined("car" if style != "van" else "van", parts, outlines=(outline_of(width, length),))
