"""Open places: squares, parks and car parks."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.outdoors import buildings, street_furniture, vegetation
from footprints_edge_models.scenes.assets.people import standing
from footprints_edge_models.scenes.assets.things import Patch, Thing, placement
from footprints_edge_models.scenes.assets.vehicles import cars, carts, cycles
from footprints_edge_models.scenes.layout.floor_plans import Rect
from footprints_edge_models.scenes.layout.scene import Standpoint
from footprints_edge_models.scenes.layout.streets.site import REACH_M, Site
from footprints_edge_models.scenes.layout.streets.surfaces import pavement_surface, road_surface


def surround(site: Site, half_x: float, half_y: float, z: float) -> None:
    """Houses around a place, or trees."""
    rng = site.palette.rng
    low = rng.random() < 0.3
    for turn in range(4):
        reach, along = (half_x, half_y) if turn % 2 == 0 else (half_y, half_x)
        if rng.random() < 0.25:
            for _ in range(14):
                made = (vegetation.tree, vegetation.bush, vegetation.conifer)[rng.integers(3)](
                    site.palette
                )
                _put_turned(
                    site,
                    made,
                    turn,
                    reach + rng.uniform(0, 10),
                    float(rng.uniform(-along, along)),
                    z,
                    0.0,
                )
            continue
        y = -along
        while y < along - 4:
            wide = float(min(rng.uniform(7, 18), along - y))
            tall = float(rng.uniform(3, 7) if low else rng.uniform(6, 18))
            made = buildings.house(site.palette, wide, 12.0, tall, shop=rng.random() < 0.5)
            x, yy = _turned(turn, reach, y + wide / 2)
            site.things.append(made.at(x, yy, z, turn * np.pi / 2 - np.pi / 2))
            y += wide + (float(rng.uniform(0, 5)) if rng.random() < 0.3 else 0)


def _turned(turn: int, x: float, y: float) -> tuple[float, float]:
    point = placement(0, 0, 0, turn * np.pi / 2)[:2, :2] @ np.array([x, y])
    return float(point[0]), float(point[1])


def _put_turned(
    site: Site, thing: Thing, turn: int, x: float, y: float, z: float, yaw: float
) -> None:
    at = _turned(turn, x, y)
    site.put(thing, at[0], at[1], z, yaw + turn * np.pi / 2)


def lay_square(site: Site) -> tuple[list[Standpoint], list[float]]:
    """A paved square with houses or trees around it."""
    palette = site.palette
    rng = palette.rng
    half_x, half_y = float(rng.uniform(10, 25)), float(rng.uniform(10, 30))
    site.lay(-REACH_M, -REACH_M, REACH_M, REACH_M, 0.0, pavement_surface(palette))
    if rng.random() < 0.5:
        inlay = pavement_surface(palette)
        site.lay(-half_x * 0.6, -half_y * 0.6, half_x * 0.6, half_y * 0.6, 0.004, inlay)
    surround(site, half_x, half_y, 0.0)
    for _ in range(rng.poisson(10)):
        scatter(
            site,
            (
                street_furniture.bench,
                street_furniture.street_bin,
                vegetation.tree,
                street_furniture.pole,
                carts.cart,
                lambda p: cycles.bicycle(p, ridden=False),
            ),
            half_x,
            half_y,
            0.0,
        )
    for _ in range(rng.poisson(9)):
        scatter(site, (standing,), half_x, half_y, 0.0)
    return [Standpoint(-half_x * 0.8, -half_y * 0.8, half_x * 0.8, half_y * 0.8)], []


def scatter(
    site: Site,
    makers: tuple[Callable[[Palette], Thing], ...],
    half_x: float,
    half_y: float,
    z: float,
) -> None:
    """Stand one of these things at a random place, turned at random."""
    rng = site.palette.rng
    made = makers[rng.integers(len(makers))](site.palette)
    x, y = rng.uniform(-half_x, half_x), rng.uniform(-half_y, half_y)
    site.put(made, float(x), float(y), z, float(rng.uniform(-np.pi, np.pi)))


def lay_park(site: Site) -> tuple[list[Standpoint], list[float]]:
    """Grass with a winding path, trees and benches."""
    palette = site.palette
    rng = palette.rng
    site.lay(-REACH_M, -REACH_M, REACH_M, REACH_M, 0.0, palette.of("grass", tile_m=(1.5, 4.0)))
    path = palette.of("soil", "asphalt", "paving", "concrete", tile_m=(1.0, 3.0))
    half = float(rng.uniform(0.7, 2.5))
    y, x = -REACH_M, 0.0
    bend = float(rng.normal(0, 0.06))
    slope = 0.0
    while y < REACH_M - 4:  # a winding path of short quadrilaterals
        next_slope = float(np.clip(slope + bend + rng.normal(0, 0.05), -0.7, 0.7))
        end_x = x + 4 * next_slope
        site.ground.append(
            Patch(
                np.array(
                    [(x - half, y), (x + half, y), (end_x + half, y + 4), (end_x - half, y + 4)]
                ),
                0.005,
                path,
            )
        )
        if abs(y) < 60:
            site.taken.append(Rect(min(x, end_x) - half, y, max(x, end_x) + half, y + 4))
        x, y, slope = end_x, y + 4, next_slope
    for _ in range(rng.poisson(60)):
        scatter(
            site,
            (
                vegetation.tree,
                vegetation.tree,
                vegetation.bush,
                vegetation.conifer,
                street_furniture.bench,
                street_furniture.pole,
            ),
            45,
            50,
            0.0,
        )
    for _ in range(rng.poisson(9)):
        scatter(
            site,
            (street_furniture.bench, street_furniture.street_bin, vegetation.bush, standing),
            8,
            25,
            0.0,
        )
    site.taken.clear()
    for _ in range(rng.poisson(4)):
        scatter(site, (standing, standing, lambda p: cycles.bicycle(p, ridden=True)), 5, 25, 0.0)
    return [Standpoint(-7, -12, 7, 12)], [90.0, -90.0]


def lay_car_park(site: Site) -> tuple[list[Standpoint], list[float]]:
    """Rows of parking spaces, some of them taken."""
    palette = site.palette
    rng = palette.rng
    site.lay(-REACH_M, -REACH_M, REACH_M, REACH_M, 0.0, road_surface(palette))
    white = replace(palette.of("blank", "plaster"), tint=(1.2, 1.2, 1.2))
    full = float(rng.uniform(0.3, 0.95))
    aisle = float(rng.uniform(5.5, 7.5))
    for row in range(-1, 2):
        for back in (-1, 1):
            x = row * (aisle + 10) + back * (aisle / 2 + 2.5)
            for y in np.arange(-25, 27.5, 2.5):
                site.lay(x - 2.4, y - 0.05, x + 2.4, y + 0.05, 0.003, white)
                if rng.random() < full:
                    site.put(
                        cars.car(palette),
                        x + rng.normal(0, 0.15),
                        y + 1.25,
                        0.0,
                        float(rng.choice([-1, 1]) * np.pi / 2 + rng.normal(0, 0.03)),
                        0.02,
                    )
    surround(site, 32, 32, 0.0)
    for _ in range(rng.poisson(6)):
        scatter(
            site,
            (standing, street_furniture.pole, vegetation.tree, street_furniture.street_bin),
            15,
            25,
            0.0,
        )
    return [Standpoint(-4, -20, 4, 20)], [90.0, -90.0, 30.0, 150.0, -30.0]
