"""Kitchen counters and fridges."""

from footprints_edge_models.scenes.assets.furniture.storage import fronts
from footprints_edge_models.scenes.assets.furniture.tabletop import on_top
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.models import or_model
from footprints_edge_models.scenes.assets.things import Thing, box, joined


@or_model("lower cabinet", "sink", "island", "dishwasher", "oven", "cooker")
def counter(palette: Palette, width_m: float, *, island: bool = False) -> Thing:
    """A run of kitchen cupboards with a worktop; wall cupboards above it unless an island."""
    rng = palette.rng
    front, knob = palette.panel(), palette.metal()
    work = palette.of("marble", "wood", "concrete", "plain", gloss=0.08)
    deep = 0.6 if not island else float(rng.uniform(0.7, 1.1))
    parts = [
        box(palette.dark(), (width_m, deep - 0.08, 0.1), (0, 0.03, 0)),
        box(front, (width_m, deep - 0.03, 0.76), (0, 0.01, 0.1)),
        box(work, (width_m + 0.02, deep + 0.02, 0.04), (0, 0, 0.86)),
    ]
    parts += fronts(front, knob, width_m, 0.76, -deep / 2, 0.1, rng)
    parts += on_top(palette, width_m * 0.9, deep * 0.6, 0.9, 4 * width_m)
    if rng.random() < 0.6:
        x = rng.uniform(-0.3, 0.3) * width_m
        parts.append(box(palette.dark(), (0.58, 0.5, 0.012), (x, 0, 0.9)))
        if not island:
            oven = palette.of("metal", "plain", gloss=0.2)
            parts.append(box(oven, (0.58, 0.02, 0.6), (x, -deep / 2 - 0.01, 0.16)))
    if not island:
        splash = palette.of("tiles", "tiles", "plain", tile_m=(0.3, 0.8), gloss=0.1)
        parts.append(box(splash, (width_m, 0.01, 0.55), (0, deep / 2 - 0.005, 0.9)))
        if rng.random() < 0.8:
            tall = float(rng.uniform(0.55, 0.8))
            parts.append(box(front, (width_m, 0.34, tall), (0, deep / 2 - 0.17, 1.45)))
            parts += fronts(front, knob, width_m, tall, deep / 2 - 0.34, 1.45, rng)
    return joined("counter", parts)


@or_model("fridge", "refrigerator", "high cabinet", " washing machine", "dryer")
def fridge(palette: Palette) -> Thing:
    """A fridge, or a tall oven."""
    rng = palette.rng
    body = palette.of("plain", "metal", "plaster", gloss=0.12)
    tall = float(rng.uniform(1.4, 2.0))
    parts = [
        box(body, (0.6, 0.62, tall), (0, 0, 0.02)),
        box(palette.dark(), (0.56, 0.55, 0.03), (0, 0.02, 0)),
    ]
    for z, part in ((0.05, 0.58), (0.62, 0.36)):
        parts.append(box(body, (0.58, 0.04, tall * part), (0, -0.33, tall * z + 0.02)))
        parts.append(
            box(palette.metal(), (0.02, 0.03, 0.4 * part), (0.24, -0.36, tall * (z + part / 2)))
        )
    return joined("fridge", parts)
