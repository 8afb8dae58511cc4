"""Baths, toilets, basins."""

import numpy as np

from footprints_edge_models.scenes.assets.furniture.storage import built_cabinet
from footprints_edge_models.scenes.assets.furniture.tabletop import on_top
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.models import or_model
from footprints_edge_models.scenes.assets.shapes import lathe
from footprints_edge_models.scenes.assets.things import (
    Thing,
    ThingPart,
    box,
    column,
    cushion,
    joined,
    rod,
)


@or_model("bath", "shower stall")
def tub(palette: Palette) -> Thing:
    """A bath."""
    white = palette.white()
    side = palette.of("tiles", "plain", "plaster", tile_m=0.5, gloss=0.1)
    long_, wide, high = 1.7, 0.75, 0.56
    parts = [
        box(side, (long_, wide, high - 0.12), (0, 0, 0)),
        box(white, (long_, 0.08, 0.12), (0, wide / 2 - 0.04, high - 0.12)),
        box(white, (long_, 0.08, 0.12), (0, -wide / 2 + 0.04, high - 0.12)),
        box(white, (0.1, wide, 0.12), (long_ / 2 - 0.05, 0, high - 0.12)),
        box(white, (0.1, wide, 0.12), (-long_ / 2 + 0.05, 0, high - 0.12)),
        box(white, (long_ - 0.2, wide - 0.16, 0.01), (0, 0, high - 0.12)),
    ]
    if palette.rng.random() < 0.4:
        curtain = palette.of("stripes", "checks", "fabric", "plaster", "ornament", tile_m=0.6)
        for x in np.arange(-long_ / 2, long_ / 2 * palette.rng.uniform(-0.6, 1), 0.07):
            yaw = float(palette.rng.normal(0, 0.4))
            parts.append(box(curtain, (0.09, 0.015, 1.6), (x, -wide / 2 - 0.02, 0.36), yaw))
    return joined("bath", parts)


_BOWL = lathe([(0.26, 0), (0.2, 0.12), (0.24, 0.3), (0.42, 0.7), (0.5, 0.95), (0.47, 1.0)])


@or_model("toilets unit", "bidet")
def toilet(palette: Palette) -> Thing:
    """A toilet."""
    white = palette.white()
    matrix = np.array([[0.38, 0, 0, 0], [0, 0.52, 0, -0.08], [0, 0, 0.4, 0]])
    parts = [
        ThingPart(_BOWL, matrix, white),
        cushion(white, (0.38, 0.5, 0.04), (0, -0.08, 0.4), squareness=0.7),
        box(white, (0.38, 0.17, 0.4), (0, 0.26, 0.38)),
        box(white, (0.2, 0.25, 0.38), (0, 0.18, 0)),
    ]
    return joined("toilet", parts)


@or_model("washbasin", "vanity", "basin")
def basin(palette: Palette) -> Thing:
    """A basin on a cupboard or a pedestal, with a mirror's frame above."""
    rng = palette.rng
    white = palette.white()
    wide = float(rng.uniform(0.5, 1.4))
    if rng.random() < 0.6:
        parts = list(built_cabinet(palette, wide, 0.48, 0.8, laid=False).parts)
        parts.append(
            box(palette.of("marble", "plain", "wood"), (wide + 0.03, 0.5, 0.03), (0, 0, 0.8))
        )
        parts += on_top(palette, wide * 0.9, 0.3, 0.83, 3)
    else:
        parts = [column(white, 0.16, 0.78, (0, 0.08, 0), top=1.2)]
        wide = 0.55
    parts.append(cushion(white, (0.5, 0.42, 0.14), (0, 0, 0.78), squareness=0.6))
    parts.append(rod(palette.metal(), (0, 0.18, 0.9), (0, 0.1, 1.05), 0.03))
    mirror = palette.of("metal", gloss=0.85, sharpness=1.0)
    parts.append(box(mirror, (wide, 0.02, rng.uniform(0.6, 0.9)), (0, 0.23, 1.1)))
    return joined("basin", parts)
