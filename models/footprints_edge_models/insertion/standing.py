"""Chooses 3D models, and free places for them on the floor of a photo."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.insertion.photo_floor import PhotoFloor
from footprints_edge_models.scenes.assets.furniture import (
    beds,
    clutter,
    equipment,
    plants,
    seating,
    storage,
    tables,
)
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.outdoors.street_furniture import bench, street_bin
from footprints_edge_models.scenes.assets.people import standing
from footprints_edge_models.scenes.assets.shapes import convex_hull_2d
from footprints_edge_models.scenes.assets.things import Thing
from footprints_edge_models.scenes.assets.vehicles.cars import car
from footprints_edge_models.scenes.assets.vehicles.cycles import bicycle, motorbike

SHARES = (0.25, 0.35, 0.25, 0.15)
"""Of photos with one model to put in, two, three and four."""
FARTHEST_M = (9.0, 25.0)
"""Indoors and outdoors: farther things are too small to learn from."""
ON_FLOOR = 0.97
"""Least share of what is in view of a thing's place, the hull of its footprint, that is floor."""
IN_VIEW = 0.5
_TRIES = 40
_APART_M = 0.05
_NEAREST_M = 0.3
_LOWEST_RAY = 0.03

_Makers = Sequence[tuple[int, Callable[[Palette], Thing]]]


def _wide(palette: Palette, least: float, most: float) -> float:
    return float(palette.rng.uniform(least, most))


def _table(palette: Palette) -> Thing:
    size = _wide(palette, 0.5, 1.6), _wide(palette, 0.5, 0.9), _wide(palette, 0.42, 0.78)
    return tables.table(palette, *size)


def _cabinet(palette: Palette) -> Thing:
    return storage.cabinet(palette, _wide(palette, 0.4, 1.4), 0.42, _wide(palette, 0.4, 1.2))


def _shelf(palette: Palette) -> Thing:
    return storage.shelf(palette, _wide(palette, 0.4, 1.2), 0.3, _wide(palette, 0.6, 1.8))


INDOORS: _Makers = (
    (4, seating.chair),
    (2, seating.office_chair),
    (3, lambda palette: seating.sofa(palette, int(palette.rng.integers(1, 4)))),
    (1, seating.footstool),
    (4, _table),
    (1, tables.desk),
    (3, _cabinet),
    (2, _shelf),
    (2, plants.plant),
    (4, clutter.clutter),
    (1, beds.bed),
    (1, equipment.floor_lamp),
    (2, standing),
)
OUTDOORS: _Makers = (
    (4, standing),
    (5, car),
    (2, lambda palette: bicycle(palette, ridden=bool(palette.rng.random() < 0.4))),
    (1, lambda palette: motorbike(palette, ridden=False)),
    (1, street_bin),
    (1, bench),
    (1, clutter.clutter),
    (1, plants.plant),
)
"""How often, and what."""


def place_things(floor: PhotoFloor, palette: Palette) -> list[Thing]:
    """Things on the floor of a photo, no two in one place; few or none where there is no room."""
    rng = palette.rng
    makers = OUTDOORS if floor.outdoors else INDOORS
    odds = np.array([odds for odds, _ in makers]) / sum(odds for odds, _ in makers)
    rows, columns = np.nonzero(floor.mask)
    wanted = 1 + int(rng.choice(len(SHARES), p=SHARES))
    things: list[Thing] = []
    taken: list[NDArray[np.float64]] = []
    for _ in range(_TRIES):
        if len(things) == wanted:
            break
        pixel = rng.integers(len(rows))
        place = _on_ground(floor, int(rows[pixel]), int(columns[pixel]))
        if place is None:
            continue
        made = makers[rng.choice(len(makers), p=odds)][1](palette)
        thing = made.at(*place, 0.0, float(rng.uniform(-np.pi, np.pi)))
        outlines = [_points_of(outline) for outline in thing.footprints()]
        if not made.parts or not outlines:
            continue
        points = np.concatenate(outlines)
        extent = np.stack([points.min(axis=0), points.max(axis=0)])
        around = _points_of(convex_hull_2d(points))  # nothing between its legs stands before it
        if _is_on_floor(floor, around) and not any(_meet(extent, other) for other in taken):
            things.append(thing)
            taken.append(extent)
    return things


def _on_ground(floor: PhotoFloor, row: int, column: int) -> tuple[float, float] | None:
    """Where the ray of a pixel meets the ground, metres; None where that is too far."""
    k, camera = floor.camera.intrinsics, floor.camera
    ray = camera.rotation @ np.array([(column - k.cx) / k.fx, (row - k.cy) / k.fy, 1.0])
    if ray[2] > -_LOWEST_RAY:
        return None
    x, y, _ = camera.position_m + ray * camera.position_m[2] / -ray[2]
    return None if y > FARTHEST_M[floor.outdoors] else (float(x), float(y))


def _points_of(outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (N, 2) on and within a convex outline (K, 2)."""
    middle = outline.mean(axis=0)
    along = np.linspace(0, 1, 7, endpoint=False)[:, None, None]
    border = (outline + (np.roll(outline, -1, axis=0) - outline) * along).reshape(-1, 2)
    return np.concatenate([middle + (border - middle) * share for share in (1.0, 0.6, 0.2)])


def _is_on_floor(floor: PhotoFloor, points: NDArray[np.float64]) -> bool:
    camera, k = floor.camera, floor.camera.intrinsics
    away = np.column_stack([points, np.zeros(len(points))]) - camera.position_m
    right, down, ahead = (away @ camera.rotation).T
    if ahead.min() < _NEAREST_M:
        return False
    column, row = k.fx * right / ahead + k.cx, k.fy * down / ahead + k.cy
    height, width = camera.size
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    if inside.mean() < IN_VIEW:
        return False
    return bool(floor.mask[row[inside].astype(int), column[inside].astype(int)].mean() >= ON_FLOOR)


def _meet(one: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    """Whether two extents (2, 2), least and greatest corner, overlap or nearly do."""
    return bool((one[0] < other[1] + _APART_M).all() and (one[1] > other[0] - _APART_M).all())
