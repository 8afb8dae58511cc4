"""Lamps, televisions, whiteboards, machines."""

from footprints_edge_models.scenes.assets.furniture.storage import built_cabinet
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.models import or_model
from footprints_edge_models.scenes.assets.things import Thing, box, column, joined, rod


def floor_lamp(palette: Palette) -> Thing:
    """A standing lamp."""
    rng = palette.rng
    metal = palette.metal()
    tall = float(rng.uniform(1.3, 1.8))
    shade = palette.of("fabric", "plaster", glow=float(rng.choice([0, 0.8])))
    return joined(
        "lamp",
        [
            column(metal, 0.28, 0.03, (0, 0, 0)),
            rod(metal, (0, 0, 0), (0, 0, tall), 0.03),
            column(shade, 0.42, 0.3, (0, 0, tall - 0.1), top=0.7),
        ],
    )


@or_model(" tv ", "tv ", "television", "aquarium")
def television(palette: Palette) -> Thing:
    """A low board with a television."""
    rng = palette.rng
    wide = float(rng.uniform(1.2, 2.0))
    low = float(rng.uniform(0.4, 0.6))
    parts = list(built_cabinet(palette, wide, 0.42, low, laid=False).parts)
    screen = float(rng.uniform(0.9, 1.3))
    parts.append(box(palette.dark(), (screen, 0.04, screen * 0.58), (0, 0.05, low + 0.08)))
    parts.append(box(palette.glass(), (screen * 0.97, 0.01, screen * 0.55), (0, 0.025, low + 0.1)))
    parts.append(box(palette.dark(), (0.4, 0.2, 0.08), (0, 0.05, low)))
    return joined("television", parts)


def whiteboard(palette: Palette) -> Thing:
    """A board on two feet, or a screen that divides a room."""
    rng = palette.rng
    wide, tall = float(rng.uniform(1.0, 1.8)), float(rng.uniform(0.9, 1.3))
    face = palette.of("plaster", "fabric", "print", tile_m=1.5)
    parts = [box(face, (wide, 0.03, tall), (0, 0, 1.9 - tall))]
    for sx in (-1, 1):
        x = sx * wide * 0.45
        parts.append(rod(palette.metal(), (x, 0, 0.03), (x, 0, 1.9), 0.04))
        parts.append(rod(palette.metal(), (x, -0.3, 0.03), (x, 0.3, 0.03), 0.04))
    return joined("board", parts)


@or_model("printer", "copier", "water cooler", "stereo", "machine", "furnace", "bike", "boiler")
def machine(palette: Palette) -> Thing:
    """A copier, a washing machine, a vending machine."""
    rng = palette.rng
    body = palette.of("plain", "plaster", "metal", gloss=0.05)
    size = (
        float(rng.uniform(0.5, 0.9)),
        float(rng.uniform(0.5, 0.75)),
        float(rng.uniform(0.8, 1.8)),
    )
    parts = [
        box(body, size, (0, 0, 0.03)),
        box(palette.dark(), (size[0] * 0.9, size[1] * 0.8, 0.04), (0, 0, 0)),
    ]
    parts.append(
        box(palette.dark(), (size[0] * 0.6, 0.02, size[2] * 0.3), (0, -size[1] / 2, size[2] * 0.5))
    )
    parts.append(
        box(
            palette.of("print", "plain"),
            (size[0] * 0.8, 0.02, 0.12),
            (0, -size[1] / 2, size[2] * 0.88),
        )
    )
    return joined("machine", parts)
