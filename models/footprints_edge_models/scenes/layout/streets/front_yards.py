"""Houses seen from the street: lawn, drive, path, bushes, hedge."""

import numpy as np

from footprints_edge_models.scenes.assets.outdoors import (
    barriers,
    buildings,
    street_furniture,
    vegetation,
)
from footprints_edge_models.scenes.assets.people import standing
from footprints_edge_models.scenes.assets.vehicles import cars
from footprints_edge_models.scenes.layout.scene import Standpoint
from footprints_edge_models.scenes.layout.streets.site import REACH_M, Site
from footprints_edge_models.scenes.layout.streets.surfaces import pavement_surface, road_surface


def lay_front_yards(site: Site) -> tuple[list[Standpoint], list[float]]:
    """A house seen from the street: lawn, drive, path, bushes, hedge."""
    palette = site.palette
    rng = palette.rng
    site.lay(-REACH_M, -REACH_M, 0, REACH_M, 0.0, road_surface(palette))
    kerb = float(rng.choice([0.0, 0.1]))
    wide = float(rng.uniform(0.5, 2.5))
    site.lay(0, -REACH_M, wide, REACH_M, kerb, pavement_surface(palette))
    site.lay(
        wide,
        -REACH_M,
        REACH_M,
        REACH_M,
        kerb,
        palette.of("grass", "grass", "soil", tile_m=(1.5, 4.0)),
    )
    yard = float(rng.uniform(4, 14))
    y = -34.0
    drive = palette.of("concrete", "asphalt", "paving", "bricks", tile_m=(1.0, 3.0))
    while y < 34:
        front = float(rng.uniform(9, 18))
        made = buildings.house(palette, front, 10.0, float(rng.uniform(2.8, 6.5)), shop=False)
        setback = wide + yard + rng.uniform(-1, 1)
        site.things.append(made.at(setback, y + front / 2, kerb, -np.pi / 2))
        site.lay(wide, y + 0.5, setback, y + 0.5 + rng.uniform(2.5, 6), kerb + 0.004, drive)
        path_y = y + front * 0.6
        site.lay(wide, path_y, setback, path_y + 1.1, kerb + 0.003, drive)
        if rng.random() < 0.5:
            site.put(
                cars.car(palette),
                wide + yard * 0.5,
                y + 2.3,
                kerb,
                float(rng.choice([-1, 1]) * np.pi / 2),
            )
        for at in np.arange(y + 3, y + front, 1.4):
            if rng.random() < 0.5:
                site.put(
                    (vegetation.bush, vegetation.bush, vegetation.conifer)[rng.integers(3)](
                        palette
                    ),
                    setback - 0.9,
                    at,
                    kerb,
                )
        if rng.random() < 0.6:
            site.put(
                vegetation.tree(palette),
                wide + yard * rng.uniform(0.2, 0.6),
                y + front * 0.75,
                kerb,
            )
        if rng.random() < 0.4:
            make = (barriers.fence, vegetation.hedge, barriers.garden_wall)[rng.integers(3)]
            site.put(
                make(palette, front * 0.35), wide + 0.3, y + front * 0.85, kerb, np.pi / 2, 0.0
            )
        y += front + float(rng.uniform(0.5, 4))
    for _ in range(rng.poisson(2)):
        site.put(
            cars.car(palette),
            -float(rng.uniform(0.9, 1.4)),
            float(rng.normal(0, 12)),
            0.0,
            float(rng.choice([0, np.pi])),
        )
    for _ in range(rng.poisson(3)):
        site.put(
            (standing, street_furniture.street_bin, street_furniture.pole)[rng.integers(3)](
                palette
            ),
            float(rng.uniform(0.3, wide)),
            float(rng.normal(0, 10)),
            kerb,
            float(rng.uniform(-3, 3)),
        )
    return [Standpoint(-7, -10, 1, 10, 2.0), Standpoint(wide, -10, wide + yard * 0.6, 10)], [
        0.0,
        25.0,
        -25.0,
        50.0,
        -50.0,
        90.0,
    ]
