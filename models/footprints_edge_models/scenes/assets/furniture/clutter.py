"""Small things on the floor: boxes, bags, bins, clothes, shoes."""

from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.things import (
    Thing,
    blob,
    box,
    column,
    cushion,
    joined,
    rod,
)


def clutter(palette: Palette) -> Thing:
    """Something small on the floor: a box, a bag, a bin, a pile, shoes, a toy, a suitcase."""
    makers = (_carton, _bin, _bag, _suitcase, _clothes, _shoes, _ball)
    share = (0.3, 0.15, 0.15, 0.12, 0.14, 0.08, 0.06)
    return makers[int(palette.rng.choice(len(makers), p=share))](palette)


def _carton(palette: Palette) -> Thing:
    rng = palette.rng
    card = palette.of("plain", "print", "fabric", "wood", "photo", tile_m=0.5)
    size = rng.uniform(0.15, 0.6, 3)
    parts = [box(card, size, (0, 0, 0))]
    if rng.random() < 0.4:
        second = palette.of("print", "plain", "wood")
        parts.append(box(second, size * 0.7, (0, 0, size[2]), 0.3))
    return joined("box", parts)


def _bin(palette: Palette) -> Thing:
    made = palette.of("plain", "metal", gloss=0.05)
    high = float(palette.rng.uniform(0.25, 0.6))
    return joined("bin", [column(made, 0.26, high, (0, 0, 0), top=1.2)])


def _bag(palette: Palette) -> Thing:
    rng = palette.rng
    cloth = palette.cloth()
    wide, high = float(rng.uniform(0.3, 0.5)), float(rng.uniform(0.25, 0.45))
    parts = [cushion(cloth, (wide, 0.22, high), (0, 0, 0), squareness=0.4)]
    for sy in (-1, 1):
        for sx in (-1, 1):
            start = (sx * wide / 4, sy * 0.07, high - 0.03)
            parts.append(rod(cloth, start, (0, sy * 0.05, high + 0.18), 0.02))
    return joined("bag", parts)


def _suitcase(palette: Palette) -> Thing:
    shell, handle = palette.of("plain", "fabric", gloss=0.05), palette.dark()
    tall = float(palette.rng.uniform(0.5, 0.72))
    parts = [cushion(shell, (0.42, 0.26, tall - 0.04), (0, 0, 0.04), squareness=0.2)]
    parts += [rod(handle, (x, 0.1, tall), (x, 0.1, tall + 0.3), 0.015) for x in (-0.1, 0.1)]
    return joined("suitcase", parts)


def _clothes(palette: Palette) -> Thing:
    size = palette.rng.uniform(0.2, 0.7, 3) * (1, 1, 0.35)
    parts = [cushion(palette.cloth(), size, (0, 0, 0), squareness=0.7)]
    parts.append(cushion(palette.cloth(), size * 0.6, (size[0] * 0.3, 0, 0), squareness=0.8))
    return joined("clothes", parts)


def _shoes(palette: Palette) -> Thing:
    rng = palette.rng
    shoe = palette.of("plain", "fabric")
    parts = [
        cushion(shoe, (0.1, 0.27, 0.1), (sx * 0.08, rng.normal(0, 0.04), 0), squareness=0.7)
        for sx in (-1, 1)
    ]
    return joined("shoes", parts)


def _ball(palette: Palette) -> Thing:
    wide = float(palette.rng.uniform(0.1, 0.6))
    return joined("ball", [blob(palette.of("plain", "stripes"), (wide, wide, wide), (0, 0, 0))])
