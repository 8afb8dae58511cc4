"""The nearest obstacle by bearing: what a prediction reports against the measured depth.

The truth is the nearest surface between the heights of a step and of the robot above the true
ground, in the measured or exact depth. Measured depth that other frames refute is left out.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import GroundPlaneError
from footprints_edge.foundation.types import Floats
from footprints_edge.geometry.camera import Intrinsics, backproject
from footprints_edge.geometry.camera_pose import CameraPose
from footprints_edge.geometry.ground_plane import GroundPlane
from footprints_edge.geometry.obstacle_heights import ROBOT_HEIGHT_M, STEP_HEIGHT_M
from footprints_edge.prediction import Prediction
from footprints_edge_bench.accuracy.benchmark import Benchmark
from footprints_edge_bench.foundation.markdown import markdown_table
from footprints_edge_bench.ground_truth.base import GroundTruth
from footprints_edge_bench.navigation.occupancy import exact_prediction

BEARINGS_DEG = np.arange(-24.0, 25.0, 2.0)
RANGE_M = 10.0
TOO_FAR, TOO_NEAR = 1.25, 0.75
"""Ratios of reported and true distance: more than a quarter too far, or too near."""

WALKABLE = ", walkable behind things"
"""Suffix of the rows that take what is not walkable for an obstacle."""

KNOWN_POSE = ", height, pitch and roll known"
"""Suffix of the rows that are given the true pose of the camera."""

_LEAST_PX = 12
"""Pixels of the true depth that make a thing, within `_DEEP` of its distance."""

_DEEP = 0.08

_PARTS = 7
"""Parts of equal size into which ranges are divided, near to far."""


@dataclass(frozen=True, eq=False)
class ObstacleScore:
    """One image: reported and true distance by bearing, where there is a true one.

    Attributes:
        reported_m: (N,), metres; infinite where nothing is reported.
        true_m: (N,), metres.
        answered: whether the image has a ground plane; without one nothing is reported.
    """

    reported_m: NDArray[np.float64]
    true_m: NDArray[np.float64]
    answered: bool


def nearest_things_m(
    depth_m: Floats, intrinsics: Intrinsics, plane: GroundPlane, bearings_deg: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The true distance of the nearest thing within a degree of each bearing.

    Args:
        depth_m: float32 (H, W), metres; 0 where unknown.
        intrinsics: the camera, in pixels of (H, W).
        plane: the true ground.
        bearings_deg: (B,), degrees, left positive.

    Returns:
        (B,), metres; infinite where nothing stands within `RANGE_M`.
    """
    points = plane.to_ground(backproject(depth_m, intrinsics))[depth_m > 0]
    x, y = points[(points[:, 2] > STEP_HEIGHT_M) & (points[:, 2] < ROBOT_HEIGHT_M), :2].T
    range_m, bearing = np.hypot(x, y), np.degrees(np.arctan2(y, x))
    found = np.full(len(bearings_deg), np.inf)
    for index, middle in enumerate(bearings_deg):
        near = np.sort(range_m[(np.abs(bearing - middle) < 1) & (range_m < RANGE_M)])
        if len(near) >= _LEAST_PX:
            first, last = near[: len(near) - _LEAST_PX + 1], near[_LEAST_PX - 1 :]
            dense = np.flatnonzero(last < first * (1 + _DEEP))
            if dense.size:
                found[index] = first[dense[0]]
    return found


def reported_m(prediction: Prediction, suffix: str, true_plane: GroundPlane) -> Floats:
    """The distance to the nearest obstacle by `BEARINGS_DEG` that the row of a suffix reports."""
    if suffix == KNOWN_POSE:
        pose = CameraPose(true_plane.camera_height_m, true_plane.pitch_deg, true_plane.roll_deg)
        prediction = replace(prediction, pose=pose, laid_onto=None)
    if suffix == WALKABLE:
        return prediction.walkable_behind_things(range_m=RANGE_M).nearest_obstacle_m(BEARINGS_DEG)
    return prediction.scan(BEARINGS_DEG.tolist()).ranges_m


def score_obstacles(
    benchmark: Benchmark, progress: Callable[[str], None]
) -> dict[str, list[ObstacleScore]]:
    """Scores of every image that shows ground and has a true obstacle, by the name of the row."""
    scores: dict[str, list[ObstacleScore]] = {
        row + suffix: [] for row in benchmark.rows() for suffix in ("", KNOWN_POSE, WALKABLE)
    }
    for item in benchmark.items():
        ground_truth = item.load()
        predictions = benchmark.predict(ground_truth)
        exact = exact_prediction(ground_truth, next(iter(predictions.values())))
        progress(item.name)
        try:
            plane = exact.ground_plane()
        except GroundPlaneError:
            continue
        true_m = nearest_things_m(
            _believed_depth_m(ground_truth), exact.intrinsics, plane, BEARINGS_DEG
        )
        there = np.isfinite(true_m)
        if not there.any():
            continue
        for row, prediction in predictions.items():
            for suffix in ("", KNOWN_POSE, WALKABLE):
                answered, found = True, np.full(len(BEARINGS_DEG), np.inf, np.float32)
                try:
                    found = reported_m(prediction, suffix, plane)
                except GroundPlaneError:
                    answered = False
                known_m = np.where(np.isnan(found), np.inf, found).astype(np.float64)
                scores[row + suffix].append(ObstacleScore(known_m[there], true_m[there], answered))
    return scores


def _believed_depth_m(ground_truth: GroundTruth) -> Floats:
    """The true depth; 0, unknown, where other frames look through what was measured."""
    assert ground_truth.visible_depth_m is not None
    if ground_truth.false_depth is None:
        return ground_truth.visible_depth_m
    return np.where(ground_truth.false_depth(), np.float32(0), ground_truth.visible_depth_m)


def as_markdown(scores: Mapping[str, Sequence[ObstacleScore]]) -> str:
    """A table of scores over all bearings of the images that have a ground plane."""
    rows = []
    for row, of_row in scores.items():
        answered = [score for score in of_row if score.answered]
        ratio = np.concatenate(
            [score.reported_m / score.true_m for score in answered] or [np.empty(0)]
        )
        rows.append(
            [
                row,
                f"{np.median(ratio) if ratio.size else math.nan:.2f}",
                f"{_share(ratio > TOO_FAR)}",
                f"{_share(ratio < TOO_NEAR)}",
                f"{len(of_row) - len(answered)}",
                f"{ratio.size}",
            ]
        )
    heading = [
        "",
        "Median of reported / true",
        "More than 1/4 too far",
        "More than 1/4 too near",
        "Images without a plane",
        "Bearings",
    ]
    count = max((len(of_row) for of_row in scores.values()), default=0)
    return (
        f"## Nearest obstacle, {STEP_HEIGHT_M:g} to {ROBOT_HEIGHT_M:g} m high: {count} images\n\n"
        f"{markdown_table(heading, rows)}\n{_by_range(scores)}"
    )


def _by_range(scores: Mapping[str, Sequence[ObstacleScore]]) -> str:
    """Tables of the share of reported ranges that are right, by range, for the plain rows.

    `navigation/range_scan.py` holds those of the bundled model: the confidence of a scan.
    """
    tables = []
    for row, of_row in scores.items():
        if row.endswith((KNOWN_POSE, WALKABLE)) or not any(score.answered for score in of_row):
            continue
        reported_m, true_m = (
            np.concatenate([getattr(score, name) for score in of_row if score.answered])
            for name in ("reported_m", "true_m")
        )
        order = np.argsort(reported_m, kind="stable")
        parts = np.array_split(order[np.isfinite(reported_m[order])], _PARTS)
        cells = []
        for part in parts:
            ratio = reported_m[part] / true_m[part]
            right = (ratio <= TOO_FAR) & (ratio >= TOO_NEAR)
            if part.size:
                cells.append([f"{np.median(reported_m[part]):.2f}", f"{right.mean():.2f}"])
        heading = [f"{row}: range (m)", "Within a quarter of the true one"]
        tables.append(f"\n{markdown_table(heading, cells)}\n")
    return "".join(tables)


def _share(where: NDArray[np.bool_]) -> str:
    return f"{where.mean():.1%}" if where.size else "-"
