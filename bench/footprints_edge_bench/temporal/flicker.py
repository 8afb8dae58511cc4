"""Temporal consistency: how much maps flicker, and what smoothing costs in accuracy.

Consecutive frames are aligned by their ground-truth poses: visible surfaces by the measured depth,
the ground by the floor plane of the clip. The differences that remain are flicker.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Mask
from footprints_edge.geometry.camera import Intrinsics, backproject
from footprints_edge.model import Model
from footprints_edge.prediction import Prediction
from footprints_edge.video.smoothing import Tracker
from footprints_edge_bench.accuracy.baselines import estimate_of
from footprints_edge_bench.accuracy.scoring import judge
from footprints_edge_bench.foundation.markdown import markdown_table
from footprints_edge_bench.ground_truth.base import GroundTruth, Item
from footprints_edge_bench.ground_truth.clip import open_clip
from footprints_edge_bench.ground_truth.datasets import Subset

if TYPE_CHECKING:
    from footprints_edge_models.mapping.floor_map import DepthFrame

FARTHEST_M = 8.0
"""Ground farther away is not compared: a pixel covers half a metre there."""

_SAME_SURFACE = 0.05
"""Measured depths that differ by less than this share belong to one surface."""

Smooth = Callable[[Prediction], Prediction]


@dataclass(frozen=True)
class FlickerScores:
    """Flicker and accuracy of one way of smoothing; NaN where there is nothing to measure.

    Attributes:
        visible_flicker: share of the visible surface that changes between visible ground and not.
        ground_flicker: share of the floor plane that changes between ground and not.
        ground_depth_flicker: median change of ln(ground depth) on the floor plane that the camera's
            motion does not explain.
        visible_depth_flicker: the same for the visible depth.
        visible_iou: mean IoU of visible ground.
        ground_iou: mean freespace IoU.
        ground_a1: mean a1 of the ground depth.
        visible_a1: mean a1 of the visible depth.
    """

    visible_flicker: float
    ground_flicker: float
    ground_depth_flicker: float
    visible_depth_flicker: float
    visible_iou: float
    ground_iou: float
    ground_a1: float
    visible_a1: float


@dataclass(frozen=True, eq=False)
class _View:
    """A frame of the clip.

    Attributes:
        measured: measured depth and pose.
        floor_depth_m: depth of the floor plane, (H, W), metres, 0 above the horizon.
        ground_truth: the ground truth of the frame.
    """

    measured: "DepthFrame"
    floor_depth_m: NDArray[np.float64]
    ground_truth: GroundTruth


def measure(
    folder: Path, subset: Subset, model: Model, smoothings: Mapping[str, Callable[[], Smooth]]
) -> dict[str, FlickerScores]:
    """Measures several ways of smoothing on one clip.

    Args:
        folder: the clip.
        subset: frames to use; `every` drops frames as a slower camera would.
        model: the model to predict with.
        smoothings: by name; each makes a function that is called with the prediction of every
            frame in order and returns the smoothed one.
    """
    smoothers = {name: make() for name, make in smoothings.items()}
    scores: dict[str, list[list[float]]] = {name: [] for name in smoothings}
    before: dict[str, Prediction] = {}
    last: _View | None = None
    for view in _views(folder, subset):
        predicted = model.predict(view.ground_truth.image, intrinsics=view.ground_truth.intrinsics)
        pairs = None if last is None else (_surface(last, view), _floor(last, view))
        for name, smooth in smoothers.items():
            now = smooth(predicted)
            large = now.at_size(view.ground_truth.size)
            flicker = [math.nan] * 4
            if pairs is not None and last is not None:
                flicker = _flicker(before[name], large, last, view, *pairs)
            scores[name].append([*flicker, *_accuracy(now, view.ground_truth)])
            before[name] = large
        last = view
    return {name: FlickerScores(*_means(rows)) for name, rows in scores.items()}


def _views(folder: Path, subset: Subset) -> Iterator[_View]:
    clip, title = open_clip(folder), folder.resolve().name
    frames = {f"{title}/{frame.name}": frame for frame in clip.sequence.frames}
    items = (Item(name, partial(clip.ground_truth, frame)) for name, frame in frames.items())
    for item in subset.of(title, tuple(items)):
        measured = frames[item.name].measured()
        yield _View(measured, measured.depth_to_m(clip.floor_map.plane), item.load())


def _means(rows: Sequence[Sequence[float]]) -> list[float]:
    columns = (
        [value for value in column if not math.isnan(value)] for column in zip(*rows, strict=True)
    )
    return [math.fsum(column) / len(column) if column else math.nan for column in columns]


def _accuracy(prediction: Prediction, ground_truth: GroundTruth) -> list[float]:
    scores = judge(estimate_of(prediction, ground_truth.size), ground_truth)
    return [
        math.nan if part is None else float(getattr(part, measure))
        for part, measure in (
            (scores.visible_ground, "iou"),
            (scores.freespace, "iou"),
            (scores.ground_depth, "a1"),
            (scores.visible_depth, "a1"),
        )
    ]


def _surface(last: _View, now: _View) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Flat indices of pixels of two frames that show the same place: (last, now)."""
    depth_m = now.measured.depth_m
    here, there, seen_m = _projected(depth_m, now.measured, last.measured)
    measured_m = last.measured.depth_m.ravel()[there]
    same = np.abs(measured_m - seen_m) < _SAME_SURFACE * seen_m
    return there[same], here[same]


def _floor(last: _View, now: _View) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Flat indices of pixels of two frames that meet the floor at the same place: (last, now)."""
    near = np.where(now.floor_depth_m < FARTHEST_M, now.floor_depth_m, 0)
    here, there, _ = _projected(near, now.measured, last.measured)
    return there, here


def _projected(
    depth_m: NDArray[np.floating], source: "DepthFrame", target: "DepthFrame"
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.floating]]:
    """Projects pixels of `source` that have a depth into `target`.

    Returns:
        Flat indices in `source`, flat indices in `target`, and depths in `target`, metres, of the
        pixels that are in view of both.
    """
    height, width = depth_m.shape
    source_to_target = np.linalg.inv(target.camera_to_world) @ source.camera_to_world
    here = np.flatnonzero(depth_m > 0)
    seen_here = backproject(depth_m.astype(np.float32), source.intrinsics).reshape(-1, 3)[here]
    points = seen_here @ source_to_target[:3, :3].T + source_to_target[:3, 3]
    x, y, z = points.T
    camera: Intrinsics = target.intrinsics
    with np.errstate(divide="ignore", invalid="ignore"):
        columns = np.rint(camera.fx * x / z + camera.cx)
        rows = np.rint(camera.fy * y / z + camera.cy)
        seen = (z > 0.1) & (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    there = rows[seen].astype(np.intp) * width + columns[seen].astype(np.intp)
    return here[seen], there, z[seen]


def _flicker(
    before: Prediction,
    after: Prediction,
    last: _View,
    now: _View,
    surface: tuple[NDArray[np.intp], NDArray[np.intp]],
    floor: tuple[NDArray[np.intp], NDArray[np.intp]],
) -> list[float]:
    def changed(old: Mask, new: Mask, pairs: tuple[NDArray[np.intp], ...]) -> float:
        there, here = pairs
        return float(np.mean(old.ravel()[there] != new.ravel()[here])) if len(here) else math.nan

    def shift(
        old: NDArray[np.floating],
        new: NDArray[np.floating],
        true_old: NDArray[np.floating],
        true_new: NDArray[np.floating],
        pairs: tuple[NDArray[np.intp], ...],
    ) -> float:
        there, here = pairs
        if not len(here):
            return math.nan
        error = np.log(old.ravel()[there] / true_old.ravel()[there])
        return float(np.median(np.abs(error - np.log(new.ravel()[here] / true_new.ravel()[here]))))

    there, here = floor
    both = before.ground.ravel()[there] & after.ground.ravel()[here]
    standing = (there[both], here[both])
    return [
        changed(before.visible_ground, after.visible_ground, surface),
        changed(before.ground, after.ground, floor),
        shift(
            before.unmasked_ground_depth_m,
            after.unmasked_ground_depth_m,
            last.floor_depth_m,
            now.floor_depth_m,
            standing,
        ),
        shift(
            before.visible_depth_m,
            after.visible_depth_m,
            last.measured.depth_m,
            now.measured.depth_m,
            surface,
        ),
    ]


HEADINGS = {
    "visible_flicker": "Visible ground flicker",
    "ground_flicker": "Ground flicker",
    "visible_depth_flicker": "Visible depth flicker",
    "ground_depth_flicker": "Ground depth flicker",
    "visible_iou": "Visible ground IoU",
    "ground_iou": "Freespace IoU",
    "visible_a1": "Visible depth a1",
    "ground_a1": "Hidden depth a1",
}
"""Headings of the columns by attribute, in order."""

SMOOTHINGS: Mapping[str, Callable[[], Smooth]] = {
    "Frame by frame": lambda: lambda prediction: prediction,
    "Smoothed": lambda: Tracker().update,
}
"""Ways of smoothing that are compared."""


def as_markdown(clips: Mapping[str, Mapping[str, FlickerScores]]) -> str:
    """A table for every clip, with flicker in percent."""
    sections = ["## Flicker"]
    for title, scores in clips.items():
        rows = [[name, *_cells(each)] for name, each in scores.items()]
        sections.append(f"### {title}\n\n{markdown_table(['', *HEADINGS.values()], rows)}")
    return "\n\n".join(sections) + "\n"


def _cells(scores: FlickerScores) -> list[str]:
    values = {key: getattr(scores, key) for key in HEADINGS}
    return [
        f"{100 * value:.2f} %" if "flicker" in key else f"{value:.3f}"
        for key, value in values.items()
    ]
