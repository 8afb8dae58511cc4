"""The metres of a vector: from a network's maps to the plane, flat depth, grid, scan and path.

``docs/porting-metres.md`` is the same in pseudo-code.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import GroundPlaneError, PlanningError
from footprints_edge.foundation.types import Floats
from footprints_edge.geometry.camera import Intrinsics, disparity_to_depth
from footprints_edge.geometry.camera_pose import CameraPose
from footprints_edge.geometry.obstacle_heights import ROBOT_HEIGHT_M
from footprints_edge.inputs.images import DecodedImage
from footprints_edge.maps.decode import DecodedMaps
from footprints_edge.maps.ground_maps import ModelInfo
from footprints_edge.navigation.occupancy_grid import HIDDEN, VISIBLE
from footprints_edge.navigation.path_planning import STEP_COST
from footprints_edge.prediction import Prediction

GROUND_PLANE = "ground_plane"
FLAT_DEPTH = "flat_ground_depth_m"
GRID = "occupancy"
RANGES = ("nearest_obstacle_m", "scan_m")
PATH = "path_m"
NAMES = (GROUND_PLANE, FLAT_DEPTH, GRID, *RANGES, PATH)
"""Names of the files; the first is JSON, the others are arrays."""

CELL_M, RANGE_M = 0.05, 6.0
BEARINGS_DEG = np.arange(-90.0, 91.0)

_NO_MODEL = ModelInfo("", "", "", "")
_TRIED, _STARTS = 8, 6  # goals of each kind, and starts
_LEAST_M = 1.0
_LEAST_ROUND_M = 5 * CELL_M


@dataclass(frozen=True)
class NamedPath:
    """Where a path of a vector goes from and to.

    Attributes:
        start_px: x and y in pixels of the image.
        goal_px: likewise.
        margin_m: distance to keep from what is not ground.
    """

    start_px: tuple[int, int]
    goal_px: tuple[int, int]
    margin_m: float


def prediction_of(maps: Floats, entry: Mapping[str, Any], threshold: float) -> Prediction:
    """The runtime's prediction, without its picture and before its depth is laid flat.

    Args:
        maps: float32 (1, 4, h, w).
        entry: the vector's entry in ``vectors.json``.
        threshold: probability above which a pixel is ground.
    """
    height, width = entry["image_size_px"]
    pose = entry["known_pose"]
    return Prediction(
        DecodedMaps(*maps[0, :2], *disparity_to_depth(maps[0, 2:], *entry["depth_range_m"])),
        DecodedImage(np.zeros((height, width, 3), np.uint8)),
        Intrinsics(**entry["network_intrinsics_px"]),
        threshold,
        _NO_MODEL,
        pose=CameraPose(pose["camera_height_m"], pose["pitch_deg"], pose["roll_deg"]),
    )


def metres(prediction: Prediction, entry: Mapping[str, Any]) -> dict[str, Any]:
    """What the files in `NAMES` hold; only the first two where there is no plane."""
    found: dict[str, Any] = {
        GROUND_PLANE: ground_plane(prediction),
        FLAT_DEPTH: prediction.flattened().ground_depth_m,
    }
    if found[GROUND_PLANE]["refused"] is not None:
        return found
    facts = entry["grid"]
    grid = prediction.top_down(
        facts["cell_m"], facts["range_m"], robot_height_m=facts["robot_height_m"]
    )
    found[GRID] = grid.cells
    found[RANGES[0]] = grid.nearest_obstacle_m(BEARINGS_DEG)
    found[RANGES[1]] = prediction.scan(
        BEARINGS_DEG.tolist(), robot_height_m=facts["robot_height_m"]
    ).ranges_m
    if entry["path"] is not None:
        named = entry["path"]
        path = prediction.plan(named["start_px"], named["goal_px"], margin_m=named["margin_m"])
        found[PATH] = path.places_m
    return found


def ground_plane(prediction: Prediction) -> dict[str, Any]:
    """The plane, or why it is refused, ready for JSON."""
    try:
        plane = prediction.ground_plane()
    except GroundPlaneError as error:
        return {"refused": error.reason}
    return {
        "refused": None,
        "up": plane.up.tolist(),
        "camera_height_m": plane.camera_height_m,
        "pitch_deg": plane.pitch_deg,
        "roll_deg": plane.roll_deg,
        "error_m": plane.error_m,
    }


def grid_facts(robot_height_m: float = ROBOT_HEIGHT_M) -> dict[str, Any]:
    """The grid of the vectors, as ``vectors.json`` states it."""
    rows = math.ceil(RANGE_M / CELL_M - 1e-6)
    return {
        "cell_m": CELL_M,
        "range_m": RANGE_M,
        "rows": rows,
        "columns": 2 * rows,
        "robot_height_m": robot_height_m,
    }


def find_named_path(prediction: Prediction, margin_m: float) -> NamedPath | None:
    """A path from the nearest visible ground to the farthest ground, behind something if it can."""
    try:
        grid = prediction.top_down(CELL_M, RANGE_M)
    except GroundPlaneError:
        return None
    away_m = np.linalg.norm(grid.places_m, axis=-1)
    camera = prediction.intrinsics.scaled(prediction.map_size, prediction.image_size)

    def pixels(value: int) -> list[tuple[int, int]]:
        places = grid.places_m[grid.cells == value]
        order = np.argsort(away_m[grid.cells == value], kind="stable")
        found = np.rint(grid.plane.to_pixels(places[order], camera)).astype(int)
        return [(int(x), int(y)) for x, y in found]

    visible, hidden = pixels(VISIBLE), pixels(HIDDEN)
    farthest_first = hidden[::-1], visible[::-1]
    goals = [goal for some in farthest_first for goal in some[:: max(1, len(some) // _TRIED)]]
    for start in visible[:: max(1, len(visible) // _STARTS)]:
        for goal in goals:
            try:
                path = prediction.plan(start, goal, margin_m=margin_m)
            except PlanningError:
                continue
            if path.length_m >= _LEAST_M:
                return NamedPath(start, goal, margin_m)
    return None


def find_corner_path(prediction: Prediction) -> NamedPath | None:
    """A path between two cells that meet in a corner of closed ones, with the longest way round.

    A planner that slips through there finds a path of a few centimetres. None if there is no such
    place, or no way round of some length.
    """
    try:
        grid = prediction.top_down(CELL_M, RANGE_M)
    except GroundPlaneError:
        return None
    camera = prediction.intrinsics.scaled(prediction.map_size, prediction.image_size)
    is_open = grid.walkable
    best, best_m = None, _LEAST_ROUND_M
    blocks = np.lib.stride_tricks.sliding_window_view(is_open, (2, 2))
    is_half = blocks.sum(axis=(2, 3)) == 2
    for first, second in (((0, 0), (1, 1)), ((0, 1), (1, 0))):
        meets = blocks[(..., *first)] & blocks[(..., *second)] & is_half
        for corner in np.argwhere(meets):
            ends_m = np.stack([grid.places_m[tuple(corner + end)] for end in (first, second)])
            ends = [(int(x), int(y)) for x, y in np.rint(grid.plane.to_pixels(ends_m, camera))]
            try:
                path = prediction.plan(*ends)
            except PlanningError:
                continue
            if path.length_m > best_m:
                best, best_m = NamedPath(ends[0], ends[1], 0.0), path.length_m
    return best


@dataclass(frozen=True)
class PathCost:
    """A port's path, judged on the plane and the grid of given maps.

    Attributes:
        cost: the integral of 1 - p* + 0.01 along it, metres.
        length_m: its length.
        closed_m: length that runs over closed cells or past their corners, but for those of its
            ends.
        ends_off_m: the larger distance of its ends from the named points.
    """

    cost: float
    length_m: float
    closed_m: float
    ends_off_m: float


def judge_path(
    prediction: Prediction, places_m: NDArray[np.floating], entry: Mapping[str, Any]
) -> PathCost:
    """What a path (N, 2) costs, and whether it is one, by the definition in the documentation."""
    plane, camera = prediction.ground_plane(), prediction.intrinsics
    image_camera = camera.scaled(prediction.map_size, prediction.image_size)
    named = np.array([entry["path"]["start_px"], entry["path"]["goal_px"]], np.float64)
    ends_m = plane.at_pixels(named, image_camera)
    range_m = float(np.linalg.norm(places_m, axis=1).max()) + 1
    grid = prediction.top_down(CELL_M, range_m, robot_height_m=entry["grid"]["robot_height_m"])
    rows, columns = grid.cells.shape
    middles, lengths_m = [], []
    for begin, end in pairwise(places_m):
        length_m = float(np.linalg.norm(end - begin))
        count = max(1, int(np.ceil(length_m / (CELL_M / 4))))
        share = (np.arange(count)[:, None] + 0.5) / count
        middles.append(begin + share * (end - begin))
        lengths_m.append(np.full(count, length_m / count))
    middle, length = np.concatenate(middles), np.concatenate(lengths_m)
    row = np.clip(np.floor(rows - middle[:, 0] / CELL_M).astype(int), 0, rows - 1)
    column = np.clip(np.floor(rows - middle[:, 1] / CELL_M).astype(int), 0, columns - 1)
    pixels = plane.to_pixels(grid.places_m[row, column], camera)
    height, width = prediction.map_size
    u, v = np.floor(np.nan_to_num(pixels, nan=-1.0) + 0.5).astype(int).T
    in_view = (u >= 0) & (u < width) & (v >= 0) & (v < height)
    cost = np.ones(len(u))
    cost[in_view] = 1 - prediction.ground_probability[v[in_view], u[in_view]] + STEP_COST
    near_end = np.linalg.norm(middle[:, None] - ends_m, axis=-1).min(axis=1) < 1.5 * CELL_M
    later = np.minimum(np.arange(len(row)) + 2, len(row) - 1)
    touched = ((row, column), (row, column[later]), (row[later], column))
    closed = ~np.all([grid.walkable[cells] for cells in touched], axis=0) & ~near_end
    return PathCost(
        float(cost @ length),
        float(length.sum()),
        float(length[closed].sum()),
        float(np.linalg.norm(places_m[[0, -1]] - ends_m, axis=1).max()),
    )
