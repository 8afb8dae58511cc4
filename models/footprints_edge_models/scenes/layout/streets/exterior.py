"""Outdoor scenes: streets, lanes, car parks, squares, parks and front yards.

A street runs along y. Everything walkable is a patch: road, pavement a kerb higher, grass, paths.
"""

from collections.abc import Callable

import numpy as np

from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.layout.scene import Scene, Standpoint
from footprints_edge_models.scenes.layout.skies import draw_sky
from footprints_edge_models.scenes.layout.streets.front_yards import lay_front_yards
from footprints_edge_models.scenes.layout.streets.places import lay_car_park, lay_park, lay_square
from footprints_edge_models.scenes.layout.streets.site import Site
from footprints_edge_models.scenes.layout.streets.street import lay_street

Layout = Callable[[Site], tuple[list[Standpoint], list[float]]]
"""Fills a site; says where a camera may stand, and which headings are likely, degrees."""

LAYOUTS: tuple[tuple[Layout, float], ...] = (
    (lay_street, 0.64),
    (lay_square, 0.11),
    (lay_park, 0.06),
    (lay_car_park, 0.08),
    (lay_front_yards, 0.11),
)
"""Kinds of outdoor scenes and their shares."""


def draw_street(palette: Palette) -> Scene:
    """An outdoor scene; along a street the camera looks towards +y, and little is behind it."""
    rng = palette.rng
    site = Site(palette)
    layout = int(rng.choice(len(LAYOUTS), p=[share for _, share in LAYOUTS]))
    points, look = LAYOUTS[layout][0](site)
    sky = draw_sky(palette, bright=1.2)
    ambient = np.array(sky.zenith) * 0.35 + np.array(sky.horizon) * 0.25
    red, green, blue = (float(v) for v in ambient)
    rise = (
        (0.0, 0.0)
        if rng.random() < 0.5
        else (float(rng.normal(0, 0.012)), float(rng.normal(0, 0.025)))
    )
    haze = float(rng.choice([1e5, 600.0, 200.0, 90.0], p=[0.45, 0.3, 0.17, 0.08]))
    return Scene(
        "street",
        tuple(site.ground),
        tuple(site.things),
        (),
        sky,
        (red, green, blue),
        tuple(points),
        rise,
        haze,
        tuple(look),
    )
