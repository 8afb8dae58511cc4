"""What stands where in a world: its surfaces grouped into things, and the ground that each takes.

Worlds come as hundreds of surfaces, by material. Those that touch each other are one thing: a table
with what lies on it. Walls are things of their own.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.asset_files.asset import Surface
from footprints_edge_models.asset_files.outlines import (
    ENCLOSED_M2,
    STANDS_BELOW_M,
    draw_outlines,
    outlines_below,
    outlines_of_cells,
    vehicle_outline,
)

LOWEST_M = 0.02
"""A thing that is lower than this lies on the floor: one walks on it."""
STOREY_M = 0.6
"""Floors that are farther apart than this in height are different storeys."""
VEHICLE_WORDS = ("hatchback", "pickup", "prius", "suv", "ambulance", "truck", "bus")

_TOUCH_M = 0.01
_MOST_KERB_M = 0.33
_LARGEST_M = {False: 3.0, True: 8.0}
"""What touches is one thing up to this size; by whether the world is outdoors."""
_FINE_M, _COARSE_M = 0.02, 0.05
_WIDE_M = 60.0


@dataclass(frozen=True, eq=False)
class TakenGround:
    """A convex outline of ground that a thing takes.

    Attributes:
        thing: Number of the thing; -1 of ground that nobody can reach, such as that in a house.
        level_m: Height of the floor that it stands on.
        outline: (K, 2).
    """

    thing: int
    level_m: float
    outline: NDArray[np.float64] = field(repr=False)


@dataclass(frozen=True, eq=False)
class WorldPlan:
    """What stands where.

    Attributes:
        thing_of: For each surface, the number of the thing that it is part of; -1 for floors.
        taken: The ground that things take.
        storeys_m: Heights of the floors, lowest first.
    """

    thing_of: tuple[int, ...] = ()
    taken: tuple[TakenGround, ...] = ()
    storeys_m: tuple[float, ...] = (0.0,)


def plan_of(
    surfaces: Sequence[Surface], feet: NDArray[np.floating], *, outdoors: bool
) -> WorldPlan:
    """The plan of a world.

    Args:
        surfaces: Its surfaces, with roles.
        feet: (V, 3), places where cameras stand, on the floor.
        outdoors: Whether it is a town: then nobody gets into its houses.
    """
    storeys = _storeys(surfaces)
    thing_of = _grouped(surfaces, outdoors=outdoors)
    taken = []
    for thing in sorted(set(thing_of) - {-1}):
        members = [s for s, owner in zip(surfaces, thing_of, strict=True) if owner == thing]
        taken += [
            TakenGround(thing, level, outline)
            for level in _levels(members, storeys)
            for outline in _outlines(members, level, outdoors=outdoors)
        ]
    level = _storey_of(float(np.median(feet[:, 2])), storeys) if len(feet) else storeys[0]
    within = np.array([_storey_of(float(z), storeys) == level for z in feet[:, 2]], bool)
    taken += _enclosed(taken, feet[within, :2], level, outdoors=outdoors)
    return WorldPlan(tuple(thing_of), tuple(taken), tuple(storeys))


def has_word(name: str, words: Iterable[str]) -> bool:
    """Whether one of the words is in a name such as `city_bus_2` or `CityBus`, as a whole word."""
    found = {word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+", name)}
    return not found.isdisjoint(words)


def _storeys(surfaces: Sequence[Surface]) -> list[float]:
    """Heights of the floors, the middle of each storey's by area."""
    corners = [s.points[s.triangles] for s in surfaces if s.role == "floor"]
    if not corners:
        return [0.0]
    triangles = np.concatenate(corners).astype(np.float64)
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = np.linalg.norm(across, axis=1) / 2
    up = across[:, 2] > 1.4 * area
    heights, area = triangles[up].mean(axis=1)[:, 2], area[up]
    if not len(heights):
        return [0.0]
    order = np.argsort(heights)
    heights, area = heights[order], area[order]
    parts = np.split(np.arange(len(heights)), np.flatnonzero(np.diff(heights) > STOREY_M) + 1)
    found = []
    for part in parts:
        half = np.searchsorted(np.cumsum(area[part]), area[part].sum() / 2)
        found.append(round(float(heights[part[min(half, len(part) - 1)]]), 3))
    return found


def _storey_of(height_m: float, storeys: Sequence[float]) -> float:
    """The storey whose floor is the next below."""
    below = [storey for storey in storeys if storey < height_m + STOREY_M / 2]
    return max(below, default=storeys[0])


def _grouped(surfaces: Sequence[Surface], *, outdoors: bool) -> list[int]:
    """The number of the thing of each surface; -1 for floors."""
    lows = np.array([s.points.min(axis=0) for s in surfaces]).reshape(-1, 3) - _TOUCH_M / 2
    highs = np.array([s.points.max(axis=0) for s in surfaces]).reshape(-1, 3) + _TOUCH_M / 2
    parent = list(range(len(surfaces)))

    def root(k: int) -> int:
        while parent[k] != k:
            k = parent[k]
        return k

    boxes = {k: (lows[k], highs[k]) for k in range(len(surfaces))}
    loose = [k for k, surface in enumerate(surfaces) if surface.role == "object"]
    loose.sort(key=lambda k: float(np.prod(highs[k] - lows[k])))
    stems: dict[str, int] = {}
    for k in loose:  # the materials of one model, whatever its size
        stem = surfaces[k].name.split(".")[0]
        if stem in stems and outdoors:
            _unite(parent, boxes, root(stems[stem]), root(k))
        stems.setdefault(stem, k)
    for place, k in enumerate(loose):
        rest = np.array(loose[place + 1 :], int)
        near = (lows[rest] <= highs[k]).all(axis=1) & (highs[rest] >= lows[k]).all(axis=1)
        for other in rest[near]:
            one, two = root(k), root(int(other))
            if one == two:
                continue
            low = np.minimum(boxes[one][0], boxes[two][0])
            high = np.maximum(boxes[one][1], boxes[two][1])
            if (high - low)[:2].max() <= _LARGEST_M[outdoors]:
                _unite(parent, boxes, one, two)
    numbers: dict[int, int] = {}
    return [
        -1 if surface.role == "floor" else numbers.setdefault(root(k), len(numbers))
        for k, surface in enumerate(surfaces)
    ]


def _unite(
    parent: list[int],
    boxes: dict[int, tuple[NDArray[np.floating], NDArray[np.floating]]],
    one: int,
    two: int,
) -> None:
    if one != two:
        parent[two] = one
        (low, high), (low2, high2) = boxes[one], boxes[two]
        boxes[one] = (np.minimum(low, low2), np.maximum(high, high2))


def _levels(members: Sequence[Surface], storeys: Sequence[float]) -> list[float]:
    """Heights of the floors that a thing may stand on."""
    low = min(float(surface.points[:, 2].min()) for surface in members)
    high = max(float(surface.points[:, 2].max()) for surface in members)
    if members[0].role in {"wall", "stairs"}:
        return [level for level in storeys if low < level + STANDS_BELOW_M and high > level]
    level = _storey_of(low, storeys)
    # on kerbs, platforms and rugs a thing's foot tells how high they are
    return [low if level < low < level + _MOST_KERB_M - 0.1 else level]


def _outlines(
    members: Sequence[Surface], level_m: float, *, outdoors: bool
) -> list[NDArray[np.float64]]:
    triangles = np.concatenate([surface.points[surface.triangles] for surface in members])
    triangles = triangles - np.array([0, 0, level_m], np.float32)
    highest = float(triangles[..., 2].max())
    if highest < LOWEST_M:
        return []
    is_named = has_word(members[0].name, (*VEHICLE_WORDS, "car"))
    if outdoors and is_named and highest > 1:  # indoors, the car of a lift
        return [vehicle_outline(triangles)]
    # what reaches below the floor is cut off there
    triangles = triangles[triangles[..., 2].max(axis=1) > -LOWEST_M]
    if not len(triangles):
        return []
    wide = float(np.ptp(triangles[..., :2].reshape(-1, 2), axis=0).max()) > _WIDE_M
    return outlines_below(triangles, _COARSE_M if wide else _FINE_M)


def _enclosed(
    taken: Sequence[TakenGround], feet: NDArray[np.floating], level_m: float, *, outdoors: bool
) -> list[TakenGround]:
    """Ground that cannot be reached from where cameras stand.

    It is in cupboards, and outdoors in houses.
    """
    outlines = [each.outline for each in taken if abs(each.level_m - level_m) < STOREY_M]
    if not outlines or not len(feet):
        return []
    cell_m = _COARSE_M if outdoors else _FINE_M
    points = np.concatenate(outlines)
    corner = points.min(axis=0) - 2 * cell_m
    columns, rows = (np.ceil(np.ptp(points, axis=0) / cell_m).astype(int) + 5).tolist()
    grid = np.zeros((rows, columns), np.uint8)
    draw_outlines(grid, outlines, corner, cell_m)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(1 - grid, connectivity=4)
    inside = stats[:, cv2.CC_STAT_AREA] * cell_m**2 < (np.inf if outdoors else ENCLOSED_M2)
    inside[np.concatenate([labels[[0, -1]].ravel(), labels[:, [0, -1]].ravel()])] = False
    cells = np.round((feet - corner) / cell_m).astype(int)
    known = cells[((cells >= 0) & (cells < (columns, rows))).all(axis=1)]
    inside[labels[known[:, 1], known[:, 0]]] = False
    inside[0] = False
    return [
        TakenGround(-1, level_m, outline)
        for outline in outlines_of_cells(inside[labels].astype(np.uint8), corner, cell_m)
    ]
