"""How much the maps of a clip flicker, frame by frame and smoothed, and what smoothing costs.

Consecutive frames are aligned by their true poses: what is seen by the measured depth, the ground
by the plane of the clip's floor. What then differs is flicker.
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
from footprints_edge_bench.ground_truth.base import GroundTruth, Item
from footprints_edge_bench.ground_truth.clip import open_clip
from footprints_edge_bench.ground_truth.datasets import Subset

if TYPE_CHECKING:
    from footprints_edge_models.mapping.floor_map import Frame

FARTHEST_M = 8.0
"""Ground farther away is not compared: a pixel is half a metre there."""

_SAME_SURFACE = 0.05
"""Measured depths that differ by less than this share are of one surface."""

Smooth = Callable[[Prediction], Prediction]


@dataclass(frozen=True)
class FlickerScores:
    """What is measured of one way to make the maps; NaN where there is nothing to measure.

    Attributes:
        visible_flicker: share of the seen surface that changes between visible ground and not.
        ground_flicker: share of the floor plane that changes between ground and not.
        ground_depth_flicker: median change of ln(depth) of ground on the floor plane, beyond what
            the camera's motion explains.
        visible_depth_flicker: likewise of what is seen.
        visible_iou: mean IoU of visible ground.
        ground_iou: mean freespace IoU.
        ground_a1: mean a1 of the ground's depth.
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
    """A frame of the clip: its measured depth with its pose, the floor's depth, its ground truth."""

    measured: "Frame"
    floor_depth_m: NDArray[np.float64]
    ground_truth: GroundTruth


def measure(
    folder: Path, part: Subset, model: Model, ways: Mapping[str, Callable[[], Smooth]]
) -> dict[str, FlickerScores]:
    """The figures of several ways to smooth on one clip.

    Args:
        folder: of the clip.
        part: which frames; `every` leaves frames out as a slower camera would.
        model: to predict with.
        ways: by name, makers of what turns each frame's prediction into a smooth one, in order.
    """
    smoothers = {name: make() for name, make in ways.items()}
    scores: dict[str, list[list[float]]] = {name: [] for name in ways}
    before: dict[str, Prediction] = {}
    last: _View | None = None
    for view in _views(folder, part):
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


def _views(folder: Path, part: Subset) -> Iterator[_View]:
    clip, title = open_clip(folder), folder.resolve().name
    frames = {f"{title}/{frame.name}": frame for frame in clip.sequence.frames}
    items = (Item(name, partial(clip.ground_truth, frame)) for name, frame in frames.items())
    for item in part.of(title, tuple(items)):
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
    """Flat indices of pixels of two frames that show one place: (last, now)."""
    depth_m = now.measured.depth_m
    here, there, seen_m = _projected(depth_m, now.measured, last.measured)
    measured_m = last.measured.depth_m.ravel()[there]
    same = np.abs(measured_m - seen_m) < _SAME_SURFACE * seen_m
    return there[same], here[same]


def _floor(last: _View, now: _View) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Flat indices of pixels of two frames whose rays meet one place of the floor: (last, now)."""
    near = np.where(now.floor_depth_m < FARTHEST_M, now.floor_depth_m, 0)
    here, there, _ = _projected(near, now.measured, last.measured)
    return there, here


def _projected(
    depth_m: NDArray[np.floating], source: "Frame", target: "Frame"
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.floating]]:
    """Pixels of `source` with a depth that `target` sees: theirs, the target's, depth there."""
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
"""Of the columns, in order."""

SMOOTHINGS: Mapping[str, Callable[[], Smooth]] = {
    "Frame by frame": lambda: lambda prediction: prediction,
    "Smoothed": lambda: Tracker().update,
}
"""What is compared."""


def as_markdown(clips: Mapping[str, Mapping[str, FlickerScores]]) -> str:
    """A table of every clip's figures, flicker in per cent."""
    sections = ["## Steadiness"]
    for title, ways in clips.items():
        lines = [
            "| | " + " | ".join(HEADINGS.values()) + " |",
            "| --- |" + " ---: |" * len(HEADINGS),
        ]
        for name, figures in ways.items():
            cells = []
            for key in HEADINGS:
                value = getattr(figures, key)
                cells.append(f"{100 * value:.2f} %" if "flicker" in key else f"{value:.3f}")
            lines.append(f"| {name} | " + " | ".join(cells) + " |")
        sections.append(f"### {title}\n\n" + "\n".join(lines))
    return "\n\n".join(sections) + "\n"
