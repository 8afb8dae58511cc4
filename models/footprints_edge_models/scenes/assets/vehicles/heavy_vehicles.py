"""Buses and lorries."""

from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.models import or_model
from footprints_edge_models.scenes.assets.things import Thing, box, joined
from footprints_edge_models.scenes.assets.vehicles.bodywork import hull, outline_of, wheels


@or_model(" bus ", " truck ")
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
            hull(
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
            hull(
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
    parts += wheels(palette, width, [front + length * 0.17, back - length * 0.24], 0.95)
    return joined("lorry" if lorry else "bus", parts, outlines=(outline_of(width, length),))
