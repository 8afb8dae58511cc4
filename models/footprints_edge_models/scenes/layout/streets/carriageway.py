"""What is on a road: lane markings, patches, traffic."""

from dataclasses import replace

import numpy as np

from footprints_edge_models.scenes.assets.people import standing
from footprints_edge_models.scenes.assets.vehicles import cars, cycles, heavy_vehicles
from footprints_edge_models.scenes.layout.streets.site import Site


def mark_lanes(site: Site, half: float, gap: tuple[float, float], junction: bool) -> None:
    """Paint lane lines and a crossing, and mend the surface here and there."""
    palette = site.palette
    rng = palette.rng
    white = replace(
        palette.of("concrete", "plaster", "blank"),
        tint=(1.3, 1.3, float(rng.choice([1.3, 1.25, 0.7]))),
    )
    if half > 2.4 and rng.random() < 0.65:
        dash, pause = float(rng.uniform(1.5, 4)), float(rng.choice([0.0, 3.0, 5.0]))
        lanes = [0.0] if half < 5.5 else [0.0, half / 2, -half / 2]
        for x in lanes:
            y = -40.0
            while y < 80:
                if not gap[0] - dash < y < gap[1]:
                    site.lay(x - 0.06, y, x + 0.06, y + dash, 0.003, white)
                y += dash + max(pause, 0.0 if x == 0 else 3.0)
    if rng.random() < 0.3:
        for side in (-1, 1):
            x = side * (half - 0.35)
            site.lay(x - 0.05, -80, x + 0.05, min(gap[0], 80), 0.003, white)
    if rng.random() < 0.25:
        y = gap[0] - 5 if junction else float(rng.uniform(4, 18))
        for x in np.arange(-half + 0.4, half - 0.5, 1.0):
            site.lay(x, y, x + 0.5, y + 3, 0.004, white)
    dark = palette.of("asphalt", "concrete", tile_m=2.0)
    for _ in range(rng.poisson(2)):
        x, y = rng.uniform(-half, half - 0.6), rng.normal(0, 15)
        size = rng.uniform(0.4, 2.5, 2)
        site.lay(x, y, min(x + size[0], half), y + size[1], 0.002, dark)


def drive_traffic(site: Site, half: float) -> None:
    """Put vehicles on the lanes, and people who cross them."""
    palette = site.palette
    rng = palette.rng
    busy = float(rng.choice([0.0, 0.4, 1.0]))
    lanes = [half * 0.4] if half < 5 else [half * 0.22, half * 0.6]
    for side in (-1, 1):
        if half < 2.6 and side > 0:
            continue
        for lane in lanes:
            y = -25.0
            while y < 52 and busy:
                y += float(rng.exponential(10 / busy)) + 5
                dice = rng.random()
                if dice < 0.62:
                    made = cars.car(palette)
                elif dice < 0.72:
                    made = heavy_vehicles.bus(palette)
                elif dice < 0.88:
                    made = cycles.motorbike(palette, ridden=True)
                else:
                    made = cycles.bicycle(palette, ridden=True)
                x = side * lane + rng.normal(0, 0.25)
                site.put(
                    made, float(x), y, 0.0, np.pi * (side > 0) + float(rng.normal(0, 0.06)), 0.3
                )
    for _ in range(rng.poisson(0.8)):
        site.put(
            standing(palette),
            float(rng.uniform(-half, half)),
            float(rng.normal(0, 15)),
            0.0,
            float(rng.choice([-1, 1]) * np.pi / 2 + rng.normal(0, 0.4)),
        )
