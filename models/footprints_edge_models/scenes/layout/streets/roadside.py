"""What stands beside a road: houses, yards, trees, poles, people, parked cars."""

import numpy as np

from footprints_edge_models.scenes.assets.outdoors import (
    barriers,
    buildings,
    street_furniture,
    vegetation,
)
from footprints_edge_models.scenes.assets.people import standing
from footprints_edge_models.scenes.assets.vehicles import cars, carts, cycles, heavy_vehicles
from footprints_edge_models.scenes.layout.streets.site import Site, lay_side


def build_row(
    site: Site, x: float, side: int, start: float, end: float, *, low: bool, z: float
) -> None:
    """Houses whose fronts stand at ``x`` and look towards the street, side by side."""
    rng = site.palette.rng
    y = start
    shops = rng.random() < 0.5
    while y < end - 5:
        wide = float(min(rng.uniform(6, 18), end - y))
        tall = float(rng.uniform(2.8, 7) if low else rng.uniform(5, 18))
        if rng.random() < (0.3 if low else 0.08):  # a gap between houses
            gap = float(rng.uniform(2, 10))
            front = barriers.garden_wall if rng.random() < 0.5 else barriers.fence
            if rng.random() < 0.5:
                site.put(front(site.palette, gap), x, y + gap / 2, z, side * np.pi / 2 * -1, 0.0)
            y += gap
            continue
        made = buildings.house(
            site.palette,
            wide,
            float(rng.uniform(8, 13)),
            tall,
            shop=shops and not low and rng.random() < 0.7,
        )
        site.things.append(
            made.at(x + side * rng.uniform(0, 0.4), y + wide / 2, z, -side * np.pi / 2)
        )
        y += wide + (float(rng.uniform(1, 6)) if low else 0.0)


def plant_edge(site: Site, side: int, x: float, start: float, end: float, z: float) -> None:
    """Trees, bushes, a fence or a barrier where no houses are."""
    palette = site.palette
    rng = palette.rng
    style = rng.random()
    if style < 0.5:
        make = (barriers.fence, vegetation.hedge, barriers.garden_wall, barriers.barrier)[
            rng.integers(4)
        ]
        for y in np.arange(start, end, 6.0):
            if rng.random() < 0.9:
                site.put(make(palette, 6.0), side * x, y + 3, z, np.pi / 2, 0.0)
    for y in np.arange(start, end, float(rng.uniform(3, 9))):
        made = (vegetation.tree, vegetation.tree, vegetation.bush, vegetation.conifer)[
            rng.integers(4)
        ](palette)
        site.put(made, side * (x + rng.uniform(1, 12)), y + rng.normal(0, 1), z)


def lay_yards(
    site: Site, side: int, near: float, far: float, start: float, end: float, z: float
) -> None:
    """Front yards between a pavement and houses: fences, drives, trees."""
    palette = site.palette
    rng = palette.rng
    if rng.random() < 0.6:
        make = (barriers.fence, vegetation.hedge, barriers.garden_wall)[rng.integers(3)]
        y = start
        while y < end:
            long_ = float(rng.uniform(3, 8))
            site.put(make(palette, long_), side * (near + 0.3), y + long_ / 2, z, np.pi / 2, 0.0)
            y += long_ + float(rng.choice([0.0, 1.2, 3.0]))
    drive = palette.of("concrete", "paving", "asphalt", "soil", tile_m=(1.0, 3.0))
    for y in np.arange(start, end, float(rng.uniform(8, 16))):
        if rng.random() < 0.6:
            lay_side(site, side, near, far, y, y + float(rng.uniform(1, 3.2)), z + 0.004, drive)
    for _ in range(rng.poisson(0.12 * (end - start))):
        made = (
            vegetation.tree,
            vegetation.bush,
            vegetation.bush,
            vegetation.conifer,
            street_furniture.street_bin,
            cars.car,
        )[rng.integers(6)](palette)
        x = side * rng.uniform(near + 0.8, max(near + 0.9, far - 0.8))
        site.put(
            made,
            float(x),
            float(rng.uniform(start, end)),
            z,
            float(rng.choice([np.pi / 2, -np.pi / 2])),
        )


def furnish_roadside(
    site: Site,
    side: int,
    half: float,
    wide: float,
    start: float,
    end: float,
    z: float,
) -> None:
    """What stands on a pavement: trees and poles near the kerb, people, bins, benches."""
    palette = site.palette
    rng = palette.rng
    near = half + 0.5
    if half > 2.6 and rng.random() < 0.7:
        park_cars(site, side, half + (1.2 if wide > 1.5 and rng.random() < 0.1 else 0), start, end)
    if wide < 0.5:
        near = half + 0.3
        wide = 1.5
    trees, poles = rng.random() < 0.4, rng.random() < 0.6
    if trees:
        for y in np.arange(start, end, float(rng.uniform(6, 14))):
            if rng.random() < 0.85:
                site.put(vegetation.tree(palette), side * near, y, z)
    if poles:
        for y in np.arange(start + 2, end, float(rng.uniform(9, 25))):
            site.put(
                street_furniture.pole(palette),
                side * near,
                y + rng.normal(0, 1),
                z,
                side * np.pi / 2,
            )
    for _ in range(rng.poisson(0.06 * (end - start))):
        made = (
            street_furniture.street_bin,
            street_furniture.bench,
            street_furniture.pole,
            street_furniture.street_bin,
            lambda p: cycles.bicycle(p, ridden=False),
            lambda p: cycles.motorbike(p, ridden=False),
            carts.cart,
        )[rng.integers(7)](palette)
        x = near + rng.uniform(0, max(0.1, wide - 0.7))
        site.put(
            made,
            side * x,
            float(rng.uniform(start, end)),
            z,
            float(rng.choice([0, np.pi / 2, -np.pi / 2])) + rng.normal(0, 0.1),
        )
    for _ in range(rng.poisson(float(rng.choice([1, 4, 10])))):
        x = half + 0.3 + rng.random() * max(0.2, wide - 0.5)
        y = rng.normal(0, 20)
        if start < y < end:
            site.put(
                standing(palette),
                side * x,
                float(y),
                z,
                float(rng.choice([0, np.pi]) + rng.normal(0, 0.5)),
            )


def park_cars(site: Site, side: int, edge: float, start: float, end: float) -> None:
    """A row of parked vehicles whose outer sides are at ``edge``."""
    palette = site.palette
    rng = palette.rng
    share = float(rng.uniform(0.2, 0.9))
    y = start + float(rng.uniform(0, 4))
    while y < end:
        if rng.random() > share:
            y += float(rng.uniform(2, 7))
            continue
        dice = rng.random()
        if dice < 0.9:
            made = cars.car(palette)
        elif dice < 0.94:
            made = heavy_vehicles.bus(palette)
        else:
            made = cycles.motorbike(palette, ridden=False)
        low, high = made.extent
        x = edge - high[0] - rng.uniform(0.1, 0.4)
        site.put(made, side * x, y + high[1], 0.0, np.pi * (side > 0) + rng.normal(0, 0.03))
        y += float(high[1] - low[1]) + float(rng.uniform(0.5, 1.6))
