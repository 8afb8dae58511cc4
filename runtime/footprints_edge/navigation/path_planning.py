"""Path planning over visible and hidden ground (the paper's "Use case: Path Planning")."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import NoPathError, OffGroundError, OutsideError, PlanningError
from footprints_edge.foundation.install_hint import install_hint
from footprints_edge.foundation.types import Mask
from footprints_edge.geometry.ground_plane import GroundPlane
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.navigation.obstacles import Obstacles, find_obstacles
from footprints_edge.navigation.occupancy_grid import (
    HIDDEN,
    OCCUPIED,
    UNKNOWN,
    VISIBLE,
    OccupancyGrid,
    grid_with,
)

Ground: TypeAlias = Literal["all", "visible"]
Unit: TypeAlias = Literal["px", "m"]

STEP_COST = 0.01
"""Added to every cell's cost: where probabilities round to 1, the shortest path wins."""

_CELL_M, _CELLS_AHEAD = 0.05, 400
"""Side of a cell; larger where the ends are more than 20 m away, so that the graph stays small."""

_FARTHEST_M = 100.0

_DETOUR, _DETOUR_M = 1.25, 2.0
"""The grid reaches this much farther than the farther end: a factor, and metres."""


@dataclass(frozen=True, eq=False)
class GroundPath:
    """A path over the ground, from start to goal.

    Attributes:
        pixels: float64 (N, 2), x and y in pixels of the picture; (0, 0) is the centre of its top
            left pixel. The path is straight between its corners; its points are at most a cell
            apart.
        places_m: float64 (N, 2), the same points on the ground plane: x forward and y left, metres,
            from the point below the camera.
        hidden: bool (N,), whether the ground is hidden behind something here.
        cost: The integral of `1 - s* + STEP_COST` along the path, metres.
        length_m: Length on the ground plane, metres.
    """

    pixels: NDArray[np.float64]
    places_m: NDArray[np.float64]
    hidden: Mask
    cost: float
    length_m: float

    @property
    def passes_hidden_ground(self) -> bool:
        """Whether any part of the path is hidden."""
        return bool(self.hidden.any())


def find_path(
    prediction: GroundMaps,
    start: Sequence[float],
    goal: Sequence[float],
    *,
    unit: Unit = "px",
    margin_m: float = 0.0,
    ground: Ground = "all",
    robot_height_m: float | None = None,
) -> GroundPath:
    """Finds the cheapest path over the ground; see `Prediction.plan`."""
    if unit not in {"px", "m"}:
        raise PlanningError(f"unit is {unit!r}; give 'px' or 'm'")
    if ground not in {"all", "visible"}:
        raise PlanningError(f"ground is {ground!r}; give 'all' or 'visible'")
    if not (np.isfinite(margin_m) and margin_m >= 0):
        raise PlanningError(f"margin_m is {margin_m}; give metres, 0 or more")
    require_graph_search()
    from scipy.ndimage import distance_transform_edt

    plane = prediction.ground_plane()
    names = [
        f"the {name} {tuple(map(float, point))} {unit}"
        for name, point in (("start", _pair(start, "start")), ("goal", _pair(goal, "goal")))
    ]
    obstacles = find_obstacles(prediction, robot_height_m)
    ends = [
        _end(prediction, plane, obstacles, _pair(point, name), unit, ground, name)
        for name, point in (("start", start), ("goal", goal))
    ]
    ends_m = [place_m for place_m, _ in ends]
    reach_m = _DETOUR * float(np.linalg.norm(ends_m, axis=1).max()) + _DETOUR_M
    cell_m = max(_CELL_M, reach_m / _CELLS_AHEAD)
    grid = grid_with(prediction, obstacles, cell_m, reach_m)
    cells = grid.cells
    route_ends = [_cell(grid, place_m) for place_m in ends_m]
    for cell, (_, pixel) in zip(route_ends, ends, strict=True):
        if cells[cell] == UNKNOWN:  # its centre is not in view, or beyond the ground's edge
            cells[cell] = VISIBLE if prediction.visible_ground[pixel] else HIDDEN
    open_ = cells == VISIBLE if ground == "visible" else cells >= VISIBLE
    cost, in_view = _costs(prediction, grid, ground)
    safe = open_
    if margin_m > 0:
        # The picture's border is no obstacle. One may reach a cell beyond its cells' centres.
        closed = (in_view & ~open_) | (cells == OCCUPIED)
        safe = open_ & ((distance_transform_edt(~closed) - 1) * cell_m >= margin_m)
    for where, cell in zip(names, route_ends, strict=True):
        if not open_[cell]:
            what = (
                "where an obstacle stands" if cells[cell] == OCCUPIED else "not on visible ground"
            )
            raise OffGroundError(f"{where} is {what}; choose another point")
        if not safe[cell]:
            raise OffGroundError(
                f"{where} is closer than margin_m={margin_m:g} to an obstacle; "
                "choose another point, or a smaller margin"
            )
    costs = np.where(safe, cost, -1)
    route, _ = cheapest_route(costs, *route_ends)
    if route is None:
        raise NoPathError(
            f"no path on {'visible ' if ground == 'visible' else ''}ground connects "
            f"{names[0].partition(' ')[2]} and {names[1].partition(' ')[2]} "
            f"with margin_m={margin_m:g}; try a smaller margin, a lower threshold, or other points"
        )
    corners_m = grid.places_m[route[:, 0], route[:, 1]]
    # An end's line to the next cell may cut the corner of a closed one; to its own cell it cannot.
    corners_m = np.concatenate([[ends_m[0]], corners_m, [ends_m[1]]])
    corners_m = _shortened(corners_m, costs, grid)
    places_m = _dense(corners_m, cell_m)
    at = _cells_of(grid, places_m)
    map_px = plane.to_pixels(places_m, prediction.intrinsics)
    return GroundPath(
        pixels=(map_px + 0.5) / _maps_per_picture(prediction) - 0.5,
        places_m=places_m,
        hidden=cells[at] == HIDDEN,
        cost=sum(_line_cost(corners_m[i : i + 2], costs, grid) for i in range(len(corners_m) - 1)),
        length_m=float(np.linalg.norm(np.diff(places_m, axis=0), axis=1).sum()),
    )


def _pair(point: Sequence[float], name: str) -> NDArray[np.float64]:
    given = np.asarray(point, np.float64)
    if given.shape != (2,) or not np.isfinite(given).all():
        raise PlanningError(f"the {name} is {point!r}; give two finite numbers")
    return given


def _maps_per_picture(prediction: GroundMaps) -> NDArray[np.float64]:
    """Scale from the picture's pixels to the maps' pixels, along x and y."""
    height, width = prediction.image_size
    rows, columns = prediction.map_size
    return np.array([columns / width, rows / height])


def _end(
    prediction: GroundMaps,
    plane: GroundPlane,
    obstacles: Obstacles,
    given: NDArray[np.float64],
    unit: Unit,
    ground: Ground,
    name: str,
) -> tuple[NDArray[np.float64], tuple[int, int]]:
    """Forward and left of a start or goal, metres, and its pixel: in view, and ground."""
    if unit == "m":
        map_px = plane.to_pixels(given, prediction.intrinsics)
    else:
        map_px = (given + 0.5) * _maps_per_picture(prediction) - 0.5
    rows, columns = prediction.map_size
    x, y = map_px
    where = f"the {name} {tuple(map(float, given))} {unit}"
    if not (-0.5 <= x < columns - 0.5 and -0.5 <= y < rows - 0.5):  # NaN is outside as well
        height, width = prediction.image_size
        raise OutsideError(
            f"{where} is outside the picture of {width} x {height} px; choose a point in view"
        )
    pixel = int(np.floor(y + 0.5)), int(np.floor(x + 0.5))
    seen = ground == "visible"
    walkable = prediction.visible_ground if seen else prediction.ground
    if not walkable[pixel]:
        probability = (
            prediction.visible_ground_probability if seen else prediction.ground_probability
        )
        raise OffGroundError(
            f"{where} is not on {'visible ' if seen else ''}ground (probability "
            f"{probability[pixel]:.2f}, threshold {prediction.threshold:g}); choose another point"
        )
    if obstacles.raised[pixel]:
        raise OffGroundError(
            f"{where} is not on ground: what is seen there lies too high above the ground plane, "
            "such as a table top; choose another point"
        )
    place_m = given if unit == "m" else plane.at_pixels(map_px, prediction.intrinsics)
    if not np.isfinite(place_m).all() or np.linalg.norm(place_m) > _FARTHEST_M:
        raise OffGroundError(
            f"{where} is at the horizon of the ground plane, or more than {_FARTHEST_M:g} m away; "
            "choose a nearer point"
        )
    return np.asarray(place_m, np.float64), pixel


def _costs(
    prediction: GroundMaps, grid: OccupancyGrid, ground: Ground
) -> tuple[NDArray[np.float64], Mask]:
    """The cost of a metre in each cell, and the cells that the picture shows."""
    probability = (
        prediction.visible_ground_probability
        if ground == "visible"
        else prediction.ground_probability
    )
    pixels = grid.plane.to_pixels(grid.places_m, prediction.intrinsics)
    height, width = prediction.map_size
    column, row = np.moveaxis(np.floor(np.nan_to_num(pixels, nan=-1) + 0.5).astype(int), -1, 0)
    in_view = (row >= 0) & (row < height) & (column >= 0) & (column < width)
    cost = np.ones(in_view.shape)
    cost[in_view] = 1 - probability[row[in_view], column[in_view]] + STEP_COST
    return cost, in_view


def _cell(grid: OccupancyGrid, place_m: NDArray[np.float64]) -> tuple[int, int]:
    row, column = _cells_of(grid, place_m[None])
    return int(row[0]), int(column[0])


def _cells_of(
    grid: OccupancyGrid, places_m: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of the cells in which places (N, 2) lie."""
    rows, columns = grid.cells.shape
    row = np.floor(rows - places_m[:, 0] / grid.cell_m).astype(np.intp)
    column = np.floor(columns / 2 - places_m[:, 1] / grid.cell_m).astype(np.intp)
    return np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1)


def _dense(corners_m: NDArray[np.float64], step_m: float) -> NDArray[np.float64]:
    """Points along straight lines between corners, at most a step apart."""
    parts = [corners_m[:1]]
    for begin, end in pairwise(corners_m):
        count = max(1, int(np.ceil(np.linalg.norm(end - begin) / step_m)))
        share = np.arange(1, count + 1)[:, None] / count
        parts.append(begin + share * (end - begin))
    return np.concatenate(parts)


def _line_cost(
    corners_m: NDArray[np.float64], costs: NDArray[np.float64], grid: OccupancyGrid
) -> float:
    """The cost of straight lines between corners; infinite if one leaves or touches what is closed.

    A line is followed in steps, which may cut a cell's corner or meet it exactly. So the cells
    beside a diagonal passage, within three steps, must be open as well.
    """
    points_m = _dense(corners_m, grid.cell_m / 4)
    row, column = _cells_of(grid, (points_m[1:] + points_m[:-1]) / 2)
    later = np.minimum(np.arange(len(row)) + 2, len(row) - 1)
    cost = costs[row, column]
    if min(cost.min(), costs[row, column[later]].min(), costs[row[later], column].min()) < 0:
        return float("inf")
    return float(cost @ np.linalg.norm(np.diff(points_m, axis=0), axis=1))


def _shortened(
    corners_m: NDArray[np.float64], costs: NDArray[np.float64], grid: OccupancyGrid
) -> NDArray[np.float64]:
    """Replaces steps from cell to cell by straight lines, where these are open and no dearer."""
    kept, begin = [0], 0
    steps = [_line_cost(corners_m[i : i + 2], costs, grid) for i in range(len(corners_m) - 1)]
    while begin < len(corners_m) - 1:
        end, detour = begin + 1, steps[begin]
        while end + 1 < len(corners_m):
            longer = detour + steps[end]
            if not _line_cost(corners_m[[begin, end + 1]], costs, grid) <= longer * (1 + 1e-6):
                break
            end, detour = end + 1, longer
        kept.append(end)
        begin = end
    return corners_m[kept]


def require_graph_search() -> None:
    """Checks that the library for planning is installed.

    Raises:
        PlanningError: If it is missing; the message says how to install it.
    """
    try:
        import scipy.ndimage
        import scipy.sparse.csgraph  # noqa: F401
    except ModuleNotFoundError as error:
        raise PlanningError(
            f"planning needs the package {error.name}; {install_hint('plan')}"
        ) from None


def cheapest_route(
    costs: NDArray[np.floating], start: tuple[int, int], goal: tuple[int, int]
) -> tuple[NDArray[np.intp] | None, float]:
    """Finds the cheapest path through a grid of costs, by Dijkstra's algorithm.

    A step leads to one of the eight neighbours. It costs its length times the mean of its two
    cells. A diagonal one touches two more cells, at their corners; both must be open.

    Args:
        costs: (h, w), negative where no path may go.
        start: Row and column.
        goal: Row and column.

    Returns:
        Rows and columns of the path, (N, 2), and its cost; None and infinity if there is no path.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    rows, columns = (np.flatnonzero((costs >= 0).any(axis=axis)) for axis in (1, 0))
    corner = np.array([rows[0], columns[0]])
    inside = costs[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1].astype(np.float64)
    begin, end = (
        int(np.ravel_multi_index(place - corner, inside.shape)) for place in (start, goal)
    )
    graph = coo_array(_steps(inside), shape=(inside.size, inside.size)).tocsr()
    totals, before = dijkstra(graph, directed=False, indices=begin, return_predecessors=True)
    if not np.isfinite(totals[end]):
        return None, float("inf")
    route = [end]
    while route[-1] != begin:
        route.append(int(before[route[-1]]))
    places = np.stack(np.unravel_index(route[::-1], inside.shape), axis=1)
    return places + corner, float(totals[end])


def _steps(
    costs: NDArray[np.float64],
) -> tuple[NDArray[np.float64], tuple[NDArray[np.int32], NDArray[np.int32]]]:
    """Costs of all steps to the right and downwards, and the cells from and to which they lead."""
    cells = np.arange(costs.size, dtype=np.int32).reshape(costs.shape)
    is_open = costs >= 0
    is_square = is_open[:-1, :-1] & is_open[:-1, 1:] & is_open[1:, :-1] & is_open[1:, 1:]
    parts = []
    for of_from, of_to, may, length in (
        (np.s_[:, :-1], np.s_[:, 1:], is_open[:, :-1] & is_open[:, 1:], 1.0),
        (np.s_[:-1], np.s_[1:], is_open[:-1] & is_open[1:], 1.0),
        (np.s_[:-1, :-1], np.s_[1:, 1:], is_square, np.sqrt(2)),
        (np.s_[:-1, 1:], np.s_[1:, :-1], is_square, np.sqrt(2)),
    ):
        cost = (costs[of_from][may] + costs[of_to][may]) * (length / 2)
        parts.append((cost, cells[of_from][may], cells[of_to][may]))
    cost, *ends = map(np.concatenate, zip(*parts, strict=True))
    return cost, (ends[0], ends[1])
