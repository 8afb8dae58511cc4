"""Streets, lanes, car parks, squares, parks and front yards.

A street runs along y. Everything walkable is a patch: road, pavement a kerb higher, grass, paths.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from footprints_edge_models.scenes.assets import outdoors, vehicles
from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.people import standing
from footprints_edge_models.scenes.assets.things import Patch, Thing, placement, rectangle
from footprints_edge_models.scenes.layout.plans import Rect
from footprints_edge_models.scenes.layout.scene import Scene, Standpoint
from footprints_edge_models.scenes.layout.skies import draw_sky

REACH_M = 95.0
"""The ground ends here, beyond what a network's depth range of 100 m can tell."""


@dataclass
class Site:
    """A stretch of outdoors while it is built."""

    palette: Palette
    ground: list[Patch] = field(default_factory=list)
    things: list[Thing] = field(default_factory=list)
    taken: list[Rect] = field(default_factory=list)

    def lay(
        self, x0: float, y0: float, x1: float, y1: float, height_m: float, material: Material
    ) -> None:
        """A rectangle of ground."""
        if x1 - x0 > 1e-3 and y1 - y0 > 1e-3:
            self.ground.append(Patch(rectangle(x0, y0, x1, y1), height_m, material))

    def put(
        self,
        thing: Thing,
        x: float,
        y: float,
        z: float = 0.0,
        yaw: float = 0.0,
        margin_m: float = 0.1,
    ) -> bool:
        """Stands a thing somewhere, unless something stands there."""
        outlines = thing.footprints()
        turned = placement(x, y, 0, yaw)
        points = np.concatenate(outlines) @ turned[:2, :2].T + (x, y)
        low, high = points.min(axis=0) - margin_m, points.max(axis=0) + margin_m
        place = Rect(float(low[0]), float(low[1]), float(high[0]), float(high[1]))
        if any(place.meets(other) for other in self.taken):
            return False
        self.taken.append(place)
        self.things.append(thing.at(x, y, z, yaw))
        return True


def draw_street(palette: Palette) -> Scene:
    """Something outdoors; along a street the camera looks towards +y, and little is behind it."""
    rng = palette.rng
    site = Site(palette)
    layouts: tuple[Callable[[Site], tuple[list[Standpoint], list[float]]], ...] = (
        _street, _square, _park, _car_park, _front_yards
    )  # fmt: skip
    layout = layouts[int(rng.choice(len(layouts), p=[0.64, 0.11, 0.06, 0.08, 0.11]))]
    points, look = layout(site)
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


def _road(palette: Palette) -> Material:
    if palette.rng.random() < 0.85:
        return palette.of(
            "asphalt", tile_m=(1.5, 4.0), gloss=float(palette.rng.choice([0, 0, 0.03, 0.12]))
        )
    return palette.of("soil", "concrete", "paving", tile_m=(1.5, 3.0))


def _pavement(palette: Palette) -> Material:
    return palette.of(
        "paving", "paving", "asphalt", "concrete", "bricks", "tiles", tile_m=(0.9, 2.5)
    )


def _verge(palette: Palette) -> Material:
    return palette.of("grass", "grass", "soil", "paving", tile_m=(1.5, 4.0))


def _building_row(
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
            front = outdoors.garden_wall if rng.random() < 0.5 else outdoors.fence
            if rng.random() < 0.5:
                site.put(front(site.palette, gap), x, y + gap / 2, z, side * np.pi / 2 * -1, 0.0)
            y += gap
            continue
        made = outdoors.house(
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


def _street(site: Site) -> tuple[list[Standpoint], list[float]]:
    palette = site.palette
    rng = palette.rng
    half = float(rng.uniform(1.8, 7.5))
    road = _road(palette)
    kerb_m = float(rng.uniform(0.08, 0.16)) if rng.random() < 0.85 else 0.0
    stone = palette.of("concrete", "paving", tile_m=1.0)
    has_verge = rng.random() < 0.25
    sides = []
    for side in (-1, 1):
        wide = float(rng.choice([0.0, rng.uniform(1.2, 4.5)], p=[0.15, 0.85]))
        yard = float(rng.choice([0.0, rng.uniform(2, 9)], p=[0.5, 0.5]))
        built = rng.random() < 0.8
        sides.append((side, wide, yard, built, rng.random() < 0.4))
    junction = rng.random() < 0.35
    crossing = (float(rng.uniform(4, 40)), float(rng.uniform(2.2, 4.0)))
    gap = (crossing[0] - crossing[1], crossing[0] + crossing[1]) if junction else (REACH_M, REACH_M)
    site.lay(-half, -REACH_M, half, REACH_M, 0.0, road)
    for side, wide, yard, built, low in sides:
        pavement, verge = _pavement(palette), _verge(palette)
        for start, end in ((-REACH_M, gap[0]), (gap[1], REACH_M)):
            if end - start < 0.1:
                continue
            inner = half
            if wide:
                _lay_side(site, side, inner, inner + 0.15, start, end, kerb_m, stone)
                inner += 0.15
                if has_verge:
                    _lay_side(site, side, inner, inner + 1.5, start, end, kerb_m, verge)
                    inner += 1.5
                _lay_side(site, side, inner, inner + wide, start, end, kerb_m, pavement)
                inner += wide
            level = kerb_m if wide else 0.0
            _lay_side(
                site,
                side,
                inner,
                REACH_M,
                start,
                end,
                level,
                verge if yard or not built else pavement,
            )
            line = inner + yard
            if built:
                _building_row(
                    site, side * line, side, max(start, -25), min(end, 80), low=low, z=level
                )
            else:
                _edge(site, side, line + 1.5, max(start, -20), min(end, 60), level)
            if yard:
                _yard(site, side, inner, line, max(start, -20), min(end, 50), level)
            _roadside(site, side, half, wide, max(start, -20), min(end, 50), level)
        if junction:
            _lay_side(site, side, half, REACH_M, gap[0], gap[1], 0.0, road)
    _mark(site, half, gap, junction)
    _traffic(site, half)
    points = [Standpoint(-half, -12, half, 12, 2.0)]
    points += [
        Standpoint(
            side * (half + wide / 2) - wide / 2, -12, side * (half + wide / 2) + wide / 2, 12, 1.0
        )
        for side, wide, *_ in sides
        if wide > 1
    ]
    return points, [90.0, 90.0, 90.0, 90.0, 60.0, 120.0]


def _lay_side(
    site: Site,
    side: int,
    near: float,
    far: float,
    start: float,
    end: float,
    height_m: float,
    material: Material,
) -> None:
    x0, x1 = sorted((side * near, side * far))
    site.lay(x0, start, x1, end, height_m, material)


def _edge(site: Site, side: int, x: float, start: float, end: float, z: float) -> None:
    """Trees, bushes, a fence or a barrier where no houses are."""
    palette = site.palette
    rng = palette.rng
    style = rng.random()
    if style < 0.5:
        make = (outdoors.fence, outdoors.hedge, outdoors.garden_wall, outdoors.barrier)[
            rng.integers(4)
        ]
        for y in np.arange(start, end, 6.0):
            if rng.random() < 0.9:
                site.put(make(palette, 6.0), side * x, y + 3, z, np.pi / 2, 0.0)
    for y in np.arange(start, end, float(rng.uniform(3, 9))):
        made = (outdoors.tree, outdoors.tree, outdoors.bush, outdoors.conifer)[rng.integers(4)](
            palette
        )
        site.put(made, side * (x + rng.uniform(1, 12)), y + rng.normal(0, 1), z)


def _yard(
    site: Site, side: int, near: float, far: float, start: float, end: float, z: float
) -> None:
    palette = site.palette
    rng = palette.rng
    if rng.random() < 0.6:
        make = (outdoors.fence, outdoors.hedge, outdoors.garden_wall)[rng.integers(3)]
        y = start
        while y < end:
            long_ = float(rng.uniform(3, 8))
            site.put(make(palette, long_), side * (near + 0.3), y + long_ / 2, z, np.pi / 2, 0.0)
            y += long_ + float(rng.choice([0.0, 1.2, 3.0]))
    drive = palette.of("concrete", "paving", "asphalt", "soil", tile_m=(1.0, 3.0))
    for y in np.arange(start, end, float(rng.uniform(8, 16))):
        if rng.random() < 0.6:
            _lay_side(site, side, near, far, y, y + float(rng.uniform(1, 3.2)), z + 0.004, drive)
    for _ in range(rng.poisson(0.12 * (end - start))):
        made = (
            outdoors.tree,
            outdoors.bush,
            outdoors.bush,
            outdoors.conifer,
            outdoors.street_bin,
            vehicles.car,
        )[rng.integers(6)](palette)
        x = side * rng.uniform(near + 0.8, max(near + 0.9, far - 0.8))
        site.put(
            made,
            float(x),
            float(rng.uniform(start, end)),
            z,
            float(rng.choice([np.pi / 2, -np.pi / 2])),
        )


def _roadside(
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
        _park_cars(site, side, half + (1.2 if wide > 1.5 and rng.random() < 0.1 else 0), start, end)
    if wide < 0.5:
        near = half + 0.3
        wide = 1.5
    trees, poles = rng.random() < 0.4, rng.random() < 0.6
    if trees:
        for y in np.arange(start, end, float(rng.uniform(6, 14))):
            if rng.random() < 0.85:
                site.put(outdoors.tree(palette), side * near, y, z)
    if poles:
        for y in np.arange(start + 2, end, float(rng.uniform(9, 25))):
            site.put(outdoors.pole(palette), side * near, y + rng.normal(0, 1), z, side * np.pi / 2)
    for _ in range(rng.poisson(0.06 * (end - start))):
        made = (
            outdoors.street_bin,
            outdoors.bench,
            outdoors.pole,
            outdoors.street_bin,
            lambda p: vehicles.bicycle(p, ridden=False),
            lambda p: vehicles.motorbike(p, ridden=False),
            vehicles.cart,
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


def _park_cars(site: Site, side: int, edge: float, start: float, end: float) -> None:
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
            made = vehicles.car(palette)
        elif dice < 0.94:
            made = vehicles.bus(palette)
        else:
            made = vehicles.motorbike(palette, ridden=False)
        low, high = made.extent
        x = edge - high[0] - rng.uniform(0.1, 0.4)
        site.put(made, side * x, y + high[1], 0.0, np.pi * (side > 0) + rng.normal(0, 0.03))
        y += float(high[1] - low[1]) + float(rng.uniform(0.5, 1.6))


def _mark(site: Site, half: float, gap: tuple[float, float], junction: bool) -> None:
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


def _traffic(site: Site, half: float) -> None:
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
                    made = vehicles.car(palette)
                elif dice < 0.72:
                    made = vehicles.bus(palette)
                elif dice < 0.88:
                    made = vehicles.motorbike(palette, ridden=True)
                else:
                    made = vehicles.bicycle(palette, ridden=True)
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


def _surroundings(site: Site, half_x: float, half_y: float, z: float) -> None:
    """Houses around a place, or trees."""
    rng = site.palette.rng
    low = rng.random() < 0.3
    for turn in range(4):
        reach, along = (half_x, half_y) if turn % 2 == 0 else (half_y, half_x)
        if rng.random() < 0.25:
            for _ in range(14):
                made = (outdoors.tree, outdoors.bush, outdoors.conifer)[rng.integers(3)](
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
            made = outdoors.house(site.palette, wide, 12.0, tall, shop=rng.random() < 0.5)
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


def _square(site: Site) -> tuple[list[Standpoint], list[float]]:
    palette = site.palette
    rng = palette.rng
    half_x, half_y = float(rng.uniform(10, 25)), float(rng.uniform(10, 30))
    site.lay(-REACH_M, -REACH_M, REACH_M, REACH_M, 0.0, _pavement(palette))
    if rng.random() < 0.5:
        inlay = _pavement(palette)
        site.lay(-half_x * 0.6, -half_y * 0.6, half_x * 0.6, half_y * 0.6, 0.004, inlay)
    _surroundings(site, half_x, half_y, 0.0)
    for _ in range(rng.poisson(10)):
        _scatter(
            site,
            (
                outdoors.bench,
                outdoors.street_bin,
                outdoors.tree,
                outdoors.pole,
                vehicles.cart,
                lambda p: vehicles.bicycle(p, ridden=False),
            ),
            half_x,
            half_y,
            0.0,
        )
    for _ in range(rng.poisson(9)):
        _scatter(site, (standing,), half_x, half_y, 0.0)
    return [Standpoint(-half_x * 0.8, -half_y * 0.8, half_x * 0.8, half_y * 0.8)], []


def _scatter(
    site: Site,
    makers: tuple[Callable[[Palette], Thing], ...],
    half_x: float,
    half_y: float,
    z: float,
) -> None:
    rng = site.palette.rng
    made = makers[rng.integers(len(makers))](site.palette)
    x, y = rng.uniform(-half_x, half_x), rng.uniform(-half_y, half_y)
    site.put(made, float(x), float(y), z, float(rng.uniform(-np.pi, np.pi)))


def _park(site: Site) -> tuple[list[Standpoint], list[float]]:
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
        _scatter(
            site,
            (
                outdoors.tree,
                outdoors.tree,
                outdoors.bush,
                outdoors.conifer,
                outdoors.bench,
                outdoors.pole,
            ),
            45,
            50,
            0.0,
        )
    for _ in range(rng.poisson(9)):
        _scatter(site, (outdoors.bench, outdoors.street_bin, outdoors.bush, standing), 8, 25, 0.0)
    site.taken.clear()
    for _ in range(rng.poisson(4)):
        _scatter(site, (standing, standing, lambda p: vehicles.bicycle(p, ridden=True)), 5, 25, 0.0)
    return [Standpoint(-7, -12, 7, 12)], [90.0, -90.0]


def _car_park(site: Site) -> tuple[list[Standpoint], list[float]]:
    palette = site.palette
    rng = palette.rng
    site.lay(-REACH_M, -REACH_M, REACH_M, REACH_M, 0.0, _road(palette))
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
                        vehicles.car(palette),
                        x + rng.normal(0, 0.15),
                        y + 1.25,
                        0.0,
                        float(rng.choice([-1, 1]) * np.pi / 2 + rng.normal(0, 0.03)),
                        0.02,
                    )
    _surroundings(site, 32, 32, 0.0)
    for _ in range(rng.poisson(6)):
        _scatter(site, (standing, outdoors.pole, outdoors.tree, outdoors.street_bin), 15, 25, 0.0)
    return [Standpoint(-4, -20, 4, 20)], [90.0, -90.0, 30.0, 150.0, -30.0]


def _front_yards(site: Site) -> tuple[list[Standpoint], list[float]]:
    """A house seen from the street: lawn, drive, path, bushes, hedge."""
    palette = site.palette
    rng = palette.rng
    site.lay(-REACH_M, -REACH_M, 0, REACH_M, 0.0, _road(palette))
    kerb = float(rng.choice([0.0, 0.1]))
    wide = float(rng.uniform(0.5, 2.5))
    site.lay(0, -REACH_M, wide, REACH_M, kerb, _pavement(palette))
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
        made = outdoors.house(palette, front, 10.0, float(rng.uniform(2.8, 6.5)), shop=False)
        setback = wide + yard + rng.uniform(-1, 1)
        site.things.append(made.at(setback, y + front / 2, kerb, -np.pi / 2))
        site.lay(wide, y + 0.5, setback, y + 0.5 + rng.uniform(2.5, 6), kerb + 0.004, drive)
        path_y = y + front * 0.6
        site.lay(wide, path_y, setback, path_y + 1.1, kerb + 0.003, drive)
        if rng.random() < 0.5:
            site.put(
                vehicles.car(palette),
                wide + yard * 0.5,
                y + 2.3,
                kerb,
                float(rng.choice([-1, 1]) * np.pi / 2),
            )
        for at in np.arange(y + 3, y + front, 1.4):
            if rng.random() < 0.5:
                site.put(
                    (outdoors.bush, outdoors.bush, outdoors.conifer)[rng.integers(3)](palette),
                    setback - 0.9,
                    at,
                    kerb,
                )
        if rng.random() < 0.6:
            site.put(
                outdoors.tree(palette), wide + yard * rng.uniform(0.2, 0.6), y + front * 0.75, kerb
            )
        if rng.random() < 0.4:
            make = (outdoors.fence, outdoors.hedge, outdoors.garden_wall)[rng.integers(3)]
            site.put(
                make(palette, front * 0.35), wide + 0.3, y + front * 0.85, kerb, np.pi / 2, 0.0
            )
        y += front + float(rng.uniform(0.5, 4))
    for _ in range(rng.poisson(2)):
        site.put(
            vehicles.car(palette),
            -float(rng.uniform(0.9, 1.4)),
            float(rng.normal(0, 12)),
            0.0,
            float(rng.choice([0, np.pi])),
        )
    for _ in range(rng.poisson(3)):
        site.put(
            (standing, outdoors.street_bin, outdoors.pole)[rng.integers(3)](palette),
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
