"""The paper's path planning benchmark (section "Use case: Path Planning" and its table).

Each path leads from a random pixel of visible ground to a random pixel of hidden ground, both in
the ground truth. Each method plans it over its own ground. A path fails if it leaves the ground of
the ground truth.
"""

import csv
import io
import math
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.types import Floats, Mask
from footprints_edge.navigation.path_planning import STEP_COST, cheapest_route
from footprints_edge.prediction import Prediction
from footprints_edge_bench.accuracy.baselines import (
    BOXES,
    HULL,
    NOTHING,
    PROJECT_DOWN,
    VISIBLE,
    VOXELS,
    VOXELS_PLUS,
    baselines,
)
from footprints_edge_bench.accuracy.benchmark import Benchmark
from footprints_edge_bench.accuracy.tables import Column, table
from footprints_edge_bench.ground_truth.base import GroundTruth, Item

GROUND_TRUTH = "Ground truth ‡"
BASELINE_ROWS = (VOXELS, VOXELS_PLUS, HULL, BOXES, PROJECT_DOWN, VISIBLE, NOTHING)
"""Rows of the paper's table, and further rows of the accuracy benchmark."""

_COLUMNS = (
    Column("Failed paths", "planning", "failed", lowest_is_best=True),
    Column("Collisions", "planning", "collisions", lowest_is_best=True),
)


@dataclass(frozen=True)
class PathScore:
    """One planned path, scored against the ground truth.

    Attributes:
        item: name of the image.
        row: row of the method.
        failed: whether the path leaves the ground anywhere.
        collisions: share of its pixels that are off the ground.
    """

    item: str
    row: str
    failed: bool
    collisions: float


def plan_paths(
    benchmark: Benchmark, paths: int, seed: int, progress: Callable[[str], None]
) -> tuple[list[PathScore], dict[str, str]]:
    """Plans and scores paths on every image with visible and hidden ground.

    Args:
        benchmark: methods and images.
        paths: number of paths on each image.
        seed: seed of their end points, which are the same for all methods.
        progress: called with the name of each image when it is done.

    Returns:
        A score for each path of each row, and the images that failed, with the reason.
    """
    scores: list[PathScore] = []
    failures = {}
    for item in benchmark.items():
        try:
            scores += _scores_of(benchmark, item, paths, seed)
        except FootprintsError as error:
            failures[item.name] = str(error)
        progress(item.name)
    return scores, failures


def _scores_of(benchmark: Benchmark, item: Item, paths: int, seed: int) -> Iterator[PathScore]:
    ground_truth = item.load()
    rng = np.random.default_rng([seed, zlib.crc32(item.name.encode())])
    ends = list(random_ends(ground_truth, paths, rng))
    if not ends:
        return
    predictions = benchmark.predict(ground_truth)
    for row, ground in _grounds(benchmark, ground_truth, item.name, predictions):
        costs = 1 - ground.astype(np.float64) + STEP_COST
        for start, goal in ends:
            route, _ = cheapest_route(costs, start, goal)
            assert route is not None  # no cell is closed
            yield score_route(route, ground_truth, item.name, row)


def random_ends(
    ground_truth: GroundTruth, paths: int, rng: np.random.Generator
) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Pairs of a start on visible and a goal on hidden ground, (row, column).

    There are none if the image has no visible or no hidden ground.
    """
    if ground_truth.visible_ground is None or ground_truth.ground is None:
        return
    visible = ground_truth.visible_ground.mask & ground_truth.ground.mask
    hidden = (
        ground_truth.ground.mask
        & ~ground_truth.visible_ground.mask
        & ground_truth.visible_ground.valid
    )
    places = [np.argwhere(mask) for mask in (visible, hidden)]
    if all(map(len, places)):
        for _ in range(paths):
            start, goal = (tuple(map(int, rng.choice(place))) for place in places)
            yield (start[0], start[1]), (goal[0], goal[1])


def _grounds(
    benchmark: Benchmark, ground_truth: GroundTruth, name: str, predictions: dict[str, Prediction]
) -> Iterator[tuple[str, Floats | Mask]]:
    """The ground of each row, (H, W): probabilities of models, masks of baselines."""
    first = next(iter(predictions.values()))
    inputs = benchmark.inputs
    boxes, voxels = inputs.boxes_of(name, ground_truth), inputs.voxels_of(name, ground_truth)
    for row, estimate in baselines(first, ground_truth, name, boxes, voxels):
        if row == VISIBLE:
            yield row, first.at_size(ground_truth.size).visible_ground_probability
        elif row in BASELINE_ROWS and estimate.ground is not None:
            yield row, estimate.ground
    for row, prediction in predictions.items():
        yield row, prediction.at_size(ground_truth.size).ground_probability
    assert ground_truth.ground is not None
    yield (
        GROUND_TRUTH,
        ground_truth.ground.mask | ~ground_truth.ground.valid,
    )  # invalid pixels count as free


def score_route(
    route: NDArray[np.intp], ground_truth: GroundTruth, item: str, row: str
) -> PathScore:
    """Scores a path, (N, 2) rows and columns; pixels without valid ground truth count as free."""
    assert ground_truth.ground is not None
    at = tuple(route.T)
    off = ground_truth.ground.valid[at] & ~ground_truth.ground.mask[at]
    return PathScore(item, row, bool(off.any()), float(off.mean()))


def as_markdown(
    benchmark: Benchmark, scores: Sequence[PathScore], failures: dict[str, str], paths: int
) -> str:
    """The paper's table for all images and for each dataset."""
    groups = {each.name: {item.name for item in each.items} for each in benchmark.datasets}
    if len(groups) > 1:
        groups = {"All images": set().union(*groups.values()), **groups}
    order = [*BASELINE_ROWS, *benchmark.rows(), GROUND_TRUTH]
    sections = ["## Path planning"]
    for title, names in groups.items():
        found: dict[str, list[PathScore]] = {row: [] for row in order}
        for each in scores:
            if each.item in names:
                found[each.row].append(each)
        rows = {
            row: [
                math.fsum(score.failed for score in of_row) / len(of_row),
                math.fsum(score.collisions for score in of_row) / len(of_row),
            ]
            for row, of_row in found.items()
            if of_row
        }
        if rows:
            images = len({score.item for score in scores if score.item in names})
            heading = f"### {title}: {images} images with hidden ground, {paths} paths each"
            sections.append(f"{heading}\n\n{table(rows, _COLUMNS, lambda row: row)}")
    sections.append(
        "Lower is better. A path fails if it leaves the ground anywhere; collisions are the share "
        "of its pixels off the ground. † uses measured depth or other sensors, ‡ uses the ground "
        "truth."
    )
    sections += [f"Skipped {name}: {reason}" for name, reason in failures.items()]
    return "\n\n".join(sections) + "\n"


def write_reports(
    benchmark: Benchmark,
    scores: Sequence[PathScore],
    failures: dict[str, str],
    paths: int,
    out: Path,
) -> str:
    """Writes ``planning.md``, and ``planning.csv`` with one line per path and row.

    Returns:
        The Markdown.
    """
    out.mkdir(parents=True, exist_ok=True)
    markdown = as_markdown(benchmark, scores, failures, paths)
    (out / "planning.md").write_text(markdown, encoding="utf-8")
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["image", "method", "failed", "collisions"])
    writer.writerows([s.item, s.row, int(s.failed), f"{s.collisions:.6f}"] for s in scores)
    (out / "planning.csv").write_text(file.getvalue(), encoding="utf-8")
    return markdown
