"""Changes to a world: furniture moved and taken away, things put there, other surfaces."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from footprints_edge_models.scenes.assets.furniture import (
    clutter,
    equipment,
    plants,
    seating,
    storage,
    tables,
)
from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.outdoors import street_furniture, vegetation
from footprints_edge_models.scenes.assets.people import standing
from footprints_edge_models.scenes.assets.things import Thing, ThingPart, composed, placement
from footprints_edge_models.scenes.assets.vehicles import cars, cycles, heavy_vehicles
from footprints_edge_models.scenes.assets.worlds import LoadedWorld, WorldFloor, WorldThing
from footprints_edge_models.scenes.layout.scene import Standpoint
from footprints_edge_models.scenes.layout.streets.surfaces import (
    pavement_surface,
    road_surface,
    verge_surface,
)
from footprints_edge_models.scenes.layout.worlds.free_ground import FreeGround
from footprints_edge_models.scenes.vectors import cross

_TRIES = 8
_ROADS = ("road", "crosswalk", "asphalt", "yellowline", "whiteline")
_GREEN = ("grass", "lawn")
_LARGE_M2 = 3.0


def rearranged(
    palette: Palette, ground: FreeGround, things: Sequence[WorldThing], share: float
) -> list[Thing]:
    """The things of a world, a share of the movable ones elsewhere or gone."""
    rng = palette.rng
    kept = []
    for each in things:
        if not each.movable or rng.random() >= share:
            kept.append(each.thing)
        elif rng.random() < 0.5 and (moved := _moved(palette, ground, each)) is not None:
            kept.append(moved)
    return kept


def _moved(palette: Palette, ground: FreeGround, each: WorldThing) -> Thing | None:
    """A thing somewhere near where it stood, or nearly anywhere else."""
    rng = palette.rng
    centre = (each.low_m + each.high_m) / 2
    own = placement(-centre[0], -centre[1], -each.low_m[2])
    centred = _rebased(each.thing, own)
    for _ in range(_TRIES):
        x, y = centre[:2] + rng.normal(0, float(rng.choice([0.4, 2.0])), 2)
        turn = float(rng.normal(0, 0.5) if rng.random() < 0.6 else rng.uniform(-np.pi, np.pi))
        put = ground.put(centred, float(x), float(y), turn, each.thing.level_m)
        if put is not None:
            return put
    return None


def _rebased(thing: Thing, move: np.ndarray) -> Thing:
    """A thing with other axes of its own: its extent, too, is in those."""
    parts = tuple(replace(part, matrix=composed(move, part.matrix)) for part in thing.parts)
    outlines = tuple(outline + move[:2, 3] for outline in thing.outlines or ())
    return replace(thing, parts=parts, outlines=outlines)


def resurfaced(floor: WorldFloor, material: Material | None) -> ThingPart:
    """A floor as a part, with another material if there is one."""
    if material is None:
        return floor.part
    own = material.texture == floor.part.material.texture
    return ThingPart(floor.part.shape if own else floor.bare, floor.part.matrix, material)


def floor_materials(palette: Palette, world: LoadedWorld) -> list[Material | None]:
    """Other materials for some floors; None keeps a floor's own."""
    rng = palette.rng
    if rng.random() < 0.5:
        return _polished(palette, world)
    if not world.outdoors:
        common = palette.floor()
        return [
            common if floor.area_m2 > _LARGE_M2 else palette.floor() if rng.random() < 0.5 else None
            for floor in world.floors
        ]
    road, green, pavement = (
        draw(palette) for draw in (road_surface, verge_surface, pavement_surface)
    )
    return [
        road if is_road(floor.name) else green if _is_green(floor.name) else pavement
        for floor in world.floors
    ]


def _polished(palette: Palette, world: LoadedWorld) -> list[Material | None]:
    """The floors' own materials: indoors glossy at times, roads wet at times."""
    rng = palette.rng
    gloss = (
        float(rng.uniform(0.03, 0.3)) if rng.random() < (0.15 if world.outdoors else 0.45) else 0
    )
    sharpness = float(rng.random())
    return [
        replace(floor.part.material, gloss=gloss, sharpness=sharpness)
        if gloss and (is_road(floor.name) or not world.outdoors)
        else None
        for floor in world.floors
    ]


def papered(palette: Palette, things: Sequence[Thing]) -> list[Thing]:
    """Walls with another surface: large ones that stand upright, and ceilings."""
    wall, ceiling = palette.wall(), palette.of("blank", "plaster", tile_m=(1.2, 2.4))
    found = []
    for thing in things:
        parts = thing.parts
        if thing.is_wall:
            parts = tuple(_papered(part, wall, ceiling) for part in parts)
        found.append(replace(thing, parts=parts))
    return found


def _papered(part: ThingPart, wall: Material, ceiling: Material) -> ThingPart:
    shape = part.shape
    if shape.opaque is not None:
        return part
    corners = shape.corners.astype(np.float64)
    across = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    upright = float(np.linalg.norm(across[:, :2], axis=1).sum() / 2)
    level = float(np.abs(across[:, 2]).sum() / 2)
    if max(upright, level) < 2 * _LARGE_M2:
        return part
    bare = replace(shape, uv=None)
    return ThingPart(bare, part.matrix, wall if upright > level else ceiling)


def is_road(name: str) -> bool:
    """Whether a floor of this name is a road."""
    return any(word in name.lower() for word in _ROADS)


def _is_green(name: str) -> bool:
    return any(word in name.lower() for word in _GREEN)


def furnished(
    palette: Palette, world: LoadedWorld, ground: FreeGround, places: Sequence[Standpoint]
) -> list[Thing]:
    """Things put on free ground where cameras look."""
    rng = palette.rng
    put = []
    most = _most_things(palette, world)
    for _ in range(most):
        for _ in range(_TRIES):
            place = places[int(rng.integers(len(places)))]
            far_m = float(rng.uniform(3, 32) if world.outdoors else rng.uniform(0.9, 5.5))
            way = np.radians(rng.choice(place.look_deg) + rng.normal(0, 40))
            x = (place.x0 + place.x1) / 2 + far_m * float(np.cos(way))
            y = (place.y0 + place.y1) / 2 + far_m * float(np.sin(way))
            level = float(ground.level_m(np.array([[x, y]]), place.level_m)[0])
            if not np.isfinite(level):
                continue
            name = ground.floor_at(x, y, level)
            maker, turn = _for_floor(palette, world, ground, name, x, y, level)
            thing = ground.put(maker(palette), x, y, turn, level)
            if thing is not None:
                put.append(thing)
                break
    return put


def _most_things(palette: Palette, world: LoadedWorld) -> int:
    """How many things are tried; towns without vehicles get many."""
    rng = palette.rng
    if world.outdoors:
        empty = sum(each.movable for each in world.things) < 5
        return int(rng.integers(12, 36) if empty else rng.integers(3, 22))
    area = sum(floor.area_m2 for floor in world.floors)
    return int(rng.poisson(min(1.0 + area / 25, 7.0)))


def _for_floor(
    palette: Palette,
    world: LoadedWorld,
    ground: FreeGround,
    name: str,
    x: float,
    y: float,
    level: float,
) -> tuple[Callable[[Palette], Thing], float]:
    """A maker of something that is found on such a floor, and how it is turned."""
    rng = palette.rng
    anyhow = float(rng.uniform(-np.pi, np.pi))
    if not world.outdoors:
        return _INDOORS[int(rng.choice(len(_INDOORS), p=_INDOOR_SHARES))], anyhow
    if is_road(name):
        along = _along_road(ground, x, y, level)
        maker = _ROAD[int(rng.choice(len(_ROAD), p=_ROAD_SHARES))]
        if along is None or maker is standing:
            return maker, anyhow
        return maker, along + np.pi * int(rng.integers(2)) + float(rng.normal(0, 0.06))
    if _is_green(name):
        return _LAWN[int(rng.choice(len(_LAWN), p=_LAWN_SHARES))], anyhow
    return _PAVEMENT[int(rng.choice(len(_PAVEMENT), p=_PAVEMENT_SHARES))], anyhow


def _along_road(ground: FreeGround, x: float, y: float, level: float) -> float | None:
    """The yaw that turns +y along the road; None where it is as wide as it is long."""
    yaws = np.arange(12) * np.pi / 12
    steps = np.concatenate([np.arange(-18, 0), np.arange(1, 19)]) * 1.0
    ways = np.stack([-np.sin(yaws), np.cos(yaws)], axis=1)
    points = (np.array([x, y]) + ways[:, None] * steps[:, None]).reshape(-1, 2)
    above = np.column_stack([points, np.full(len(points), level + 0.5)]).astype(np.float32)
    hits = ground.floors.first_hits(above, np.array([[0, 0, -1]], np.float32))
    owners = ground.world.floor_triangles[1]
    names = [is_road(floor.name) for floor in ground.world.floors]
    on_road = (hits.triangle >= 0) & np.array(names)[owners[hits.triangle]]
    runs = on_road.reshape(len(yaws), len(steps))
    ahead = np.cumprod(runs[:, 18:], axis=1).sum(axis=1)
    behind = np.cumprod(runs[:, :18][:, ::-1], axis=1).sum(axis=1)
    length = ahead + behind
    if length.max() < 12 or length.min() > 24:
        return None
    best = np.flatnonzero(length == length.max())
    return float(yaws[best[len(best) // 2]])


def _bicycle(palette: Palette) -> Thing:
    return cycles.bicycle(palette, ridden=palette.rng.random() < 0.6)


def _motorbike(palette: Palette) -> Thing:
    return cycles.motorbike(palette, ridden=palette.rng.random() < 0.6)


def _cabinet(palette: Palette) -> Thing:
    rng = palette.rng
    return storage.shelf(
        palette,
        float(rng.uniform(0.4, 1.2)),
        float(rng.uniform(0.25, 0.5)),
        float(rng.uniform(0.5, 2.0)),
    )


_INDOORS = (
    standing, seating.chair, seating.office_chair, clutter.clutter, plants.plant,
    equipment.floor_lamp, _cabinet, tables.desk,
)  # fmt: skip
_INDOOR_SHARES = (0.28, 0.22, 0.08, 0.2, 0.08, 0.04, 0.06, 0.04)
_ROAD = (cars.car, heavy_vehicles.bus, _motorbike, _bicycle, standing)
_ROAD_SHARES = (0.6, 0.06, 0.08, 0.1, 0.16)
_PAVEMENT = (
    standing, _bicycle, street_furniture.pole, street_furniture.bench, street_furniture.street_bin,
    cars.car, vegetation.tree,
)  # fmt: skip
_PAVEMENT_SHARES = (0.42, 0.1, 0.14, 0.08, 0.08, 0.1, 0.08)
_LAWN = (
    standing,
    vegetation.tree,
    vegetation.bush,
    vegetation.conifer,
    street_furniture.bench,
    cars.car,
)
_LAWN_SHARES = (0.3, 0.22, 0.18, 0.1, 0.08, 0.12)
