"""Accuracy against time: models as points of one plot.

Accuracy is the mean of freespace and footprint IoU over the datasets, each of which counts alike.
Time is that of the network alone, all models in turns.
"""

import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge.foundation.types import Size
from footprints_edge.model import Model
from footprints_edge_bench.accuracy.baselines import estimate_of
from footprints_edge_bench.accuracy.benchmark import Benchmark
from footprints_edge_bench.accuracy.scoring import judge
from footprints_edge_bench.engines.backend import BackendSetting
from footprints_edge_bench.foundation.markdown import markdown_table
from footprints_edge_bench.latency.backends import LatencyError, of_model_file
from footprints_edge_bench.latency.benchmark import time_backends
from footprints_edge_bench.latency.machine import Machine
from footprints_edge_bench.latency.timing import CONFIDENCE, RESAMPLES, Ratio, TimingSummary, ratio

_COLOURS = ("#1b6ca8", "#c1440e", "#2f7d32", "#5b2a86", "#8a6d00")
_MARKERS = {"int8": "s", "fp32": "o"}
_LEAST_HEIGHT = 0.1
"""Of the axis of accuracy: differences that mean little should look little."""

Scores = Mapping[str, NDArray[np.float64]]
"""Freespace and footprint IoU (N, 2) of the N images of each dataset; NaN where one has none."""


@dataclass(frozen=True, kw_only=True)
class Point:
    """A model.

    Attributes:
        name: its name, from its file.
        precision: of its file.
        size: (H, W) of its input when it was timed.
        scores: by dataset.
        difference: ends of the 95 % interval of its accuracy minus the first model's: a bootstrap
            over the images of each dataset, the same ones for both.
        times: of the network alone.
        ratio: its time as a multiple of the first model's.
    """

    name: str
    precision: str
    size: Size
    scores: Scores
    difference: tuple[float, float]
    times: TimingSummary
    ratio: Ratio

    @property
    def accuracy(self) -> float:
        """Mean over the datasets of the means of both scores over images."""
        return accuracy(self.scores)


@dataclass(frozen=True)
class TradeOff:
    """Points of one run.

    Attributes:
        points: in the order of the models.
        machine: facts about the machine, from before the run.
        threads: threads for one frame.
        trials: timed frames of each model.
    """

    points: Sequence[Point]
    machine: Machine
    threads: int
    trials: int

    def as_markdown(self) -> str:
        """A table, and what it was measured on."""
        datasets = list(self.points[0].scores)
        rows = [
            [
                f"{each.name}, {each.precision}",
                f"{each.times.p50_ms:.1f}",
                f"{each.ratio.value:.2f} ({each.ratio.low:.2f} to {each.ratio.high:.2f})",
                f"{each.accuracy:.3f}",
                f"{each.difference[0]:+.3f} to {each.difference[1]:+.3f}",
                *(f"{v:.3f}" for name in datasets for v in np.nanmean(each.scores[name], axis=0)),
            ]
            for each in self.points
        ]
        ious = [f"{name}: {iou} IoU" for name in datasets for iou in ("freespace", "footprint")]
        columns = ["Model", "ms", "Times the first", "Accuracy", "Minus the first's", *ious]
        sizes = sorted({f"{height}x{width}" for height, width in (p.size for p in self.points)})
        return (
            f"{markdown_table(columns, rows)}\n\nMedians of {self.trials} frames of the network "
            f"alone at {', '.join(sizes)}, {self.threads} threads, in turns. {self._images()} "
            f"Intervals of {CONFIDENCE:.0%}.\n\n{self.machine.as_markdown()}\n"
        )

    def _images(self) -> str:
        counts = (f"{len(ious)} of {name}" for name, ious in self.points[0].scores.items())
        return f"Accuracy: mean of freespace and footprint IoU, images: {', '.join(counts)}."

    def draw(self, path: Path) -> None:
        """Draws the plot as PNG. The upper left corner is best."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(7.2, 4.4), layout="constrained")
        axes = figure.add_subplot()
        names = list(dict.fromkeys(each.name for each in self.points))
        for index, name in enumerate(names):
            colour, above = _COLOURS[index % len(_COLOURS)], index % 2 == 0
            points = [each for each in self.points if each.name == name]
            places = [(each.times.p50_ms, each.accuracy) for each in points]
            axes.plot(*zip(*places, strict=True), color=colour, linewidth=1)
            for each, place in zip(points, places, strict=True):
                marker = _MARKERS.get(each.precision, "D")
                axes.plot(*place, marker, color=colour, markersize=9)
                axes.annotate(
                    f"{name} {each.precision}\n{place[0]:.1f} ms, {place[1]:.3f}",
                    place,
                    xytext=(0, 9 if above else -9),
                    textcoords="offset points",
                    ha="center",
                    va="bottom" if above else "top",
                    fontsize=9,
                    color=colour,
                )
        found = [each.accuracy for each in self.points]
        middle, span = (min(found) + max(found)) / 2, max(found) - min(found)
        height = max(_LEAST_HEIGHT, 2 * span)
        axes.set(
            xlim=(0, 1.2 * max(each.times.p50_ms for each in self.points)),
            ylim=(middle - height / 2, middle + height / 2),
            xlabel="network alone, median ms a frame",
            ylabel="mean of freespace and footprint IoU",
        )
        axes.grid(visible=True, alpha=0.25)
        axes.spines[["top", "right"]].set_visible(False)
        figure.supxlabel(self._caption(), fontsize=7, color="#555555")
        png = io.BytesIO()
        figure.savefig(png, format="png", dpi=130)
        write_atomically(path, png.getvalue())

    def _caption(self) -> str:
        versions = self.machine.versions
        load = "unknown" if self.machine.load is None else f"{self.machine.load:.1f}"
        counts = ", ".join(f"{name} ({len(s)})" for name, s in self.points[0].scores.items())
        return (
            f"Images: {counts}. {self.threads} threads, {self.machine.cpu}, load {load}, "
            f"onnxruntime {versions.get('onnxruntime', 'unknown')}, "
            f"footprints-edge {versions.get('footprints-edge', 'unknown')}"
        )


def trade_off(
    benchmark: Benchmark,
    setting: BackendSetting,
    machine: Machine,
    trials: int,
    progress: Callable[[str], None] | None = None,
) -> TradeOff:
    """Scores models, then times them in turns.

    Args:
        benchmark: models and datasets.
        setting: how the models are run when they are timed.
        machine: facts about the machine, from before the run.
        trials: timed frames of each model.
        progress: called after every image, and after every trial of a model.

    Raises:
        LatencyError: a model cannot be timed, or models differ in their input size.
        FootprintsError: an image or its ground truth cannot be read.
    """
    models = list(benchmark.models.values())
    scored = _score(benchmark, models, progress)
    backends = [of_model_file(str(model.path)) for model in models]
    if len({each.size for each in backends}) > 1:
        sizes = ", ".join(f"{each.network} {each.size[0]}x{each.size[1]}" for each in backends)
        raise LatencyError(f"only models of one input size can be timed in turns: {sizes}")
    report = time_backends(backends, setting, machine, trials, progress=progress)
    points = []
    for model, scores, row in zip(models, scored, report.rows, strict=True):
        if row.summary is None:
            raise LatencyError(f"{model.path} cannot be timed: {row.reason}")
        points.append(
            Point(
                name=model.name,
                precision=model.metadata.precision,
                size=row.backend.size,
                scores=scores,
                difference=difference(scores, scored[0]),
                times=row.summary,
                ratio=ratio(row.times_ms, report.rows[0].times_ms),
            )
        )
    return TradeOff(points, machine, setting.threads, trials)


def _score(
    benchmark: Benchmark, models: Sequence[Model], progress: Callable[[str], None] | None
) -> list[dict[str, NDArray[np.float64]]]:
    """The scores of each model, by dataset."""
    scored: list[dict[str, NDArray[np.float64]]] = [{} for _ in models]
    for dataset in benchmark.datasets:
        found: list[list[tuple[float, float]]] = [[] for _ in models]
        for item in dataset.items:
            truth = item.load()
            for model, ious in zip(models, found, strict=True):
                prediction = model.predict(truth.image, intrinsics=truth.intrinsics, flatten=False)
                scores = judge(estimate_of(prediction, truth.size), truth)
                if scores.freespace is None or scores.footprint is None:
                    raise LatencyError(
                        f"{item.name} has no ground truth of hidden ground; give other datasets"
                    )
                ious.append((scores.freespace.iou, scores.footprint.iou))
            if progress is not None:
                progress(item.name)
        for kept, ious in zip(scored, found, strict=True):
            kept[dataset.name] = np.array(ious)
    return scored


def accuracy(scores: Scores) -> float:
    """Mean over the datasets of the means of both scores over images."""
    return float(np.mean([np.nanmean(ious, axis=0) for ious in scores.values()]))


def difference(scores: Scores, firsts: Scores, *, seed: int = 0) -> tuple[float, float]:
    """Ends of the interval of the accuracy of some scores minus that of others.

    Args:
        scores: of one model.
        firsts: of another, on the same images.
        seed: seed of the resampling.
    """
    drawing = np.random.default_rng(seed)
    total = np.zeros(RESAMPLES)
    for name, ious in scores.items():
        drawn = drawing.integers(0, len(ious), (RESAMPLES, len(ious)))
        means = (np.nanmean(each[drawn], axis=1) for each in (ious, firsts[name]))
        total += np.subtract(*means).mean(axis=1) / len(scores)
    low, high = np.quantile(total, [(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2]).tolist()
    return low, high
