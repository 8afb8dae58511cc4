"""Free space in metres: a model's occupancy grid against the grid of exact maps.

The grid of exact maps is accurate to a cell where the ground is one plane, as in rooms.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from footprints_edge.errors import GroundPlaneError
from footprints_edge.foundation.types import Floats, Mask
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import DecodedImage
from footprints_edge.maps.decode import DecodedMaps
from footprints_edge.maps.ground_maps import ModelInfo
from footprints_edge.navigation.occupancy_grid import OccupancyGrid
from footprints_edge.prediction import Prediction
from footprints_edge_bench.accuracy.benchmark import Benchmark
from footprints_edge_bench.accuracy.tables import Column, table
from footprints_edge_bench.ground_truth.base import GroundTruth

RANGE_M = 6.0
CELL_M = 0.05
BEARINGS_DEG = np.arange(-20.0, 21.0, 2.0)
"""Directions in which the distance to the nearest obstacle is compared."""

_SKY_M = 100.0

_COLUMNS = (
    Column("Walkable cells IoU", "grid", "iou"),
    Column("Walkable area error", "grid", "area", lowest_is_best=True),
    Column("Nearest obstacle error (m)", "grid", "obstacle", lowest_is_best=True),
    Column("Camera height error", "grid", "height", lowest_is_best=True),
    Column("Pitch error (degrees)", "grid", "pitch", lowest_is_best=True),
)


@dataclass(frozen=True)
class GridScore:
    """Scores of one grid against the exact one; NaN where there is nothing to compare.

    Attributes:
        iou: IoU of walkable cells, over cells where the ground truth is valid.
        area: relative error of the area of walkable ground.
        obstacle: median error of the distance to the nearest obstacle, metres, over directions in
            which both grids have one.
        height: relative error of the camera height.
        pitch: error of the camera pitch, degrees.
    """

    iou: float
    area: float = math.nan
    obstacle: float = math.nan
    height: float = math.nan
    pitch: float = math.nan


def exact_prediction(ground_truth: GroundTruth, like: Prediction) -> Prediction:
    """The prediction of a perfect model.

    Args:
        ground_truth: ground truth with S, S*, D and D*.
        like: a prediction for the image, which supplies the camera.
    """
    assert ground_truth.visible_ground is not None and ground_truth.ground is not None
    assert ground_truth.visible_depth_m is not None and ground_truth.ground_depth_m is not None

    def depth(depth_m: Floats) -> Floats:
        return np.where(depth_m > 0, depth_m, np.float32(_SKY_M))

    maps = DecodedMaps(
        ground_truth.visible_ground.mask.astype(np.float32),
        ground_truth.ground.mask.astype(np.float32),
        depth(ground_truth.visible_depth_m),
        depth(ground_truth.ground_depth_m),
    )
    return Prediction(
        maps,
        DecodedImage(np.zeros((*ground_truth.size, 3), np.uint8)),
        like.intrinsics.scaled(like.map_size, ground_truth.size),
        0.5,
        ModelInfo("ground truth", "exact", "0" * 64, "none"),
    )


def compare_grids(found: OccupancyGrid, exact: OccupancyGrid, valid: Mask) -> GridScore:
    """Scores a grid against the exact one.

    Args:
        found: the grid of a model.
        exact: the exact grid, of the same cells.
        valid: bool, cells to score.
    """
    overlap, either = (
        found.walkable & exact.walkable & valid,
        (found.walkable | exact.walkable) & valid,
    )
    if not either.any():
        return GridScore(math.nan)
    near, true_near = (grid.nearest_obstacle_m(BEARINGS_DEG) for grid in (found, exact))
    both = np.isfinite(near) & np.isfinite(true_near)
    areas = [float(np.count_nonzero(grid.walkable & valid)) for grid in (found, exact)]
    return GridScore(
        float(overlap.sum() / either.sum()),
        abs(areas[0] - areas[1]) / areas[1] if areas[1] else math.nan,
        float(np.median(np.abs(near[both] - true_near[both]))) if both.any() else math.nan,
        abs(found.plane.camera_height_m / exact.plane.camera_height_m - 1),
        abs(found.plane.pitch_deg - exact.plane.pitch_deg),
    )


def valid_cells(grid: OccupancyGrid, ground_truth: GroundTruth, intrinsics: Intrinsics) -> Mask:
    """Cells to score: all but those on rays where the ground truth of ground is not valid.

    Args:
        grid: the grid of exact maps.
        ground_truth: the ground truth of the image.
        intrinsics: the camera, in pixels of the ground truth.
    """
    assert ground_truth.ground is not None
    pixels = grid.plane.to_pixels(grid.places_m, intrinsics)
    x, y = np.moveaxis(np.floor(np.nan_to_num(pixels, nan=-1) + 0.5).astype(int), -1, 0)
    height, width = ground_truth.size
    seen = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    valid = np.ones(seen.shape, bool)
    valid[seen] = ground_truth.ground.valid[y[seen], x[seen]]
    return valid


def score_grids(
    benchmark: Benchmark, progress: Callable[[str], None]
) -> dict[str, list[GridScore]]:
    """Scores of every model's grid on every image that shows ground, by the name of the row.

    A model that finds no ground plane in such an image scores 0.
    """
    scores: dict[str, list[GridScore]] = {row: [] for row in benchmark.rows()}
    for item in benchmark.items():
        ground_truth = item.load()
        predictions = benchmark.predict(ground_truth)
        exact = exact_prediction(ground_truth, next(iter(predictions.values())))
        try:
            exact_grid = exact.walkable_behind_things(CELL_M, RANGE_M)
        except GroundPlaneError:
            continue
        valid = valid_cells(exact_grid, ground_truth, exact.intrinsics)
        for row, prediction in predictions.items():
            try:
                found = prediction.walkable_behind_things(CELL_M, RANGE_M)
            except GroundPlaneError:
                scores[row].append(GridScore(0.0))
                continue
            scores[row].append(compare_grids(found, exact_grid, valid))
        progress(item.name)
    return scores


def as_markdown(scores: Mapping[str, Sequence[GridScore]]) -> str:
    """A table of scores: mean IoU, medians of the errors."""
    rows = {}
    for row, of_row in scores.items():
        columns = {
            name: [getattr(each, name) for each in of_row] for name in GridScore.__annotations__
        }
        rows[row] = [_mean(columns["iou"])] + [
            _median(columns[name]) for name in ("area", "obstacle", "height", "pitch")
        ]
    count = max((len(of_row) for of_row in scores.values()), default=0)
    return (
        f"## Occupancy grids: {count} images, cells of {CELL_M:g} m up to {RANGE_M:g} m away\n\n"
        f"{table(rows, _COLUMNS, lambda row: row)}\n\n"
        "IoU: mean over images. Errors: medians.\n"
    )


def _mean(values: Sequence[float]) -> float:
    return float(np.nanmean(values)) if not np.isnan(values).all() else math.nan


def _median(values: Sequence[float]) -> float:
    return float(np.nanmedian(values)) if not np.isnan(values).all() else math.nan
