"""The accuracy benchmark: models and the paper's baselines on datasets with known ground."""

import csv
import hashlib
import io
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from footprints_edge.engines.onnxruntime_engine import runtime
from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.version import __version__
from footprints_edge.model import Model
from footprints_edge.navigation.ground_flattening import FLAT
from footprints_edge.prediction import Prediction
from footprints_edge_bench.accuracy.baselines import BASELINES, BOXES, ORACLE, VOXELS, estimate_of
from footprints_edge_bench.accuracy.failure_cases import Example, draw_examples
from footprints_edge_bench.accuracy.results import ImageScores, Results
from footprints_edge_bench.accuracy.scoring import MethodScores, score
from footprints_edge_bench.accuracy.summary import MEASURES, plain, summarise
from footprints_edge_bench.accuracy.tables import missing_rows, tables
from footprints_edge_bench.geometry.boxes import Box
from footprints_edge_bench.geometry.voxels import VoxelGrid, read_voxels
from footprints_edge_bench.ground_truth.base import EvaluationDataset, GroundTruth, Item

WORST = 10
"""So many images are shown."""
UNFLATTENED = ", not flattened"
NEEDS = {
    BOXES: "needs oriented boxes, --boxes FILE",
    VOXELS: "needs the scene in voxels, --voxels FOLDER",
    ORACLE: "needs a ground truth of visible ground and its depth",
}
"""What the rows that few datasets can have are computed from."""


class AccuracyError(FootprintsError):
    """A benchmark that cannot be run as it is asked for."""


@dataclass(frozen=True)
class BaselineInputs:
    """What others predicted for the images, for the baselines that need it.

    Attributes:
        boxes: of each image by its name, and the file they are from.
        boxes_file: where they are from; None if there are none.
        voxels: folder of ``NAME.npz``; None if there are none.
    """

    boxes: Mapping[str, tuple[Box, ...]]
    boxes_file: Path | None = None
    voxels: Path | None = None

    def boxes_of(self, name: str, ground_truth: GroundTruth) -> tuple[Box, ...] | None:
        """Boxes of an image: those given, else the dataset's own."""
        return self.boxes.get(name, ground_truth.boxes)

    def voxels_of(self, name: str, ground_truth: GroundTruth) -> VoxelGrid | None:
        """Voxels of an image, likewise; a file that is not there is a prediction that failed."""
        if self.voxels is None:
            return ground_truth.voxels
        path = self.voxels / f"{name}.npz"
        return read_voxels(path) if path.is_file() else None


@dataclass(frozen=True)
class Benchmark:
    """What is evaluated on what.

    Attributes:
        datasets: with the images that are asked for.
        models: by the name of their rows; baselines start from the first one.
        extras: for some baselines.
        options: how the datasets were read, plain values.
        unflattened: whether each model has a second row, with the ground's depth as the network
            says it instead of laid onto the ground's plane.
    """

    datasets: tuple[EvaluationDataset, ...]
    models: Mapping[str, Model]
    extras: BaselineInputs
    options: Mapping[str, Any]
    unflattened: bool = False

    def settings(self) -> dict[str, Any]:
        """Everything that the scores depend on, plain values."""
        boxes = self.extras.boxes_file
        return {
            "version": __version__,
            "runtime": runtime(),
            "models": {row: model.sha256 for row, model in self.models.items()},
            "datasets": {each.name: each.kind for each in self.datasets},
            "images": _sha256("\n".join(item.name for item in self.items()).encode()),
            "boxes": None if boxes is None else _sha256(boxes.read_bytes()),
            "voxels": None if self.extras.voxels is None else str(self.extras.voxels),
            "flat": FLAT,
            **self.options,
            **({"unflattened": True} if self.unflattened else {}),
        }

    def items(self) -> list[Item]:
        """The images of all datasets."""
        return [item for dataset in self.datasets for item in dataset.items]

    def predict(self, ground_truth: GroundTruth) -> dict[str, Prediction]:
        """Every model's prediction for an image, by the name of its row."""
        found = {}
        for row, model in self.models.items():
            plain = model.predict(
                ground_truth.image, intrinsics=ground_truth.intrinsics, flatten=False
            )
            found[row] = plain.flattened()
            if self.unflattened:
                found[row + UNFLATTENED] = plain
        return found

    def rows(self) -> list[str]:
        """The names of the rows of models, in order."""
        endings = ("", UNFLATTENED) if self.unflattened else ("",)
        return [row + ending for ending in endings for row in self.models]


def name_models(models: Sequence[Model]) -> dict[str, Model]:
    """Models by the names of their rows.

    Raises:
        AccuracyError: two would have the same.
    """
    named: dict[str, Model] = {}
    for model in models:
        row = f"Ours: {model.path.stem} ({model.metadata.precision})"
        if row in named:
            raise AccuracyError(
                f"two models would be the row {row!r}: {named[row].path} and {model.path}; give "
                "each once, in files of different names"
            )
        named[row] = model
    return named


def evaluate(
    benchmark: Benchmark, results: Results, progress: Callable[[str], None]
) -> dict[str, str]:
    """Scores every image that has no results yet.

    Args:
        benchmark: what to evaluate on what.
        results: of earlier runs with the same settings; gets the new ones, image by image.
        progress: told the name of each image when it is done.

    Returns:
        Images that failed, with the reason.
    """
    failures = {}
    for item in benchmark.items():
        if item.name not in results.images:
            try:
                results.add(item.name, _score_item(benchmark, item))
            except ImportError:
                raise
            except FootprintsError as error:
                failures[item.name] = str(error)
            except Exception as error:  # whatever it is, the other images still count
                failures[item.name] = f"{type(error).__name__}: {error}"
        progress(item.name)
    return failures


def _score_item(benchmark: Benchmark, item: Item) -> ImageScores:
    ground_truth = item.load()
    return score(
        benchmark.predict(ground_truth),
        ground_truth,
        item.name,
        benchmark.extras.boxes_of(item.name, ground_truth),
        benchmark.extras.voxels_of(item.name, ground_truth),
    )


def write_reports(
    benchmark: Benchmark, results: Results, failures: Mapping[str, str], out: Path
) -> str:
    """Writes ``accuracy.md``, ``accuracy.json``, ``per-image.csv`` and ``worst.png``.

    Returns:
        The Markdown.
    """
    order = [*BASELINES, *benchmark.rows()]
    groups = {each.name: [item.name for item in each.items] for each in benchmark.datasets}
    if len(groups) > 1:
        groups = {"All images": [item.name for item in benchmark.items()], **groups}
    sections, summaries = [], {}
    for title, names in groups.items():
        done = [results.images[name] for name in names if name in results.images]
        found = summarise(done)
        rows = {row: found[row] for row in order if row in found}
        summaries[title] = {
            row: {part: summary.as_json() for part, summary in parts.items()}
            for row, parts in rows.items()
        }
        skipped = len(names) - len(done)
        counts = f"{len(done)} images" + (f", {skipped} skipped" if skipped else "")
        section = [f"### {title}: {counts}"]
        if rows:
            section.append(tables(rows))
            notes = missing_rows(rows, NEEDS)
            section.append("\n".join(["Left out:", "", *(f"- {note}" for note in notes)]))
        sections.append("\n\n".join(section))
    settings = benchmark.settings()
    markdown = "\n\n".join(["## Accuracy", *sections, _provenance(settings, failures)]) + "\n"
    report = {"settings": settings, "skipped": dict(failures), "summaries": summaries}
    (out / "accuracy.md").write_text(markdown, encoding="utf-8")
    (out / "accuracy.json").write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    (out / "per-image.csv").write_text(_csv(benchmark, results, order), encoding="utf-8")
    examples = list(_worst(benchmark, results))
    if examples:
        draw_examples(examples).save(out / "worst.png")
    return markdown


def _provenance(settings: Mapping[str, Any], failures: Mapping[str, str]) -> str:
    lines = [
        "### What was run",
        "",
        "Means over images, images whose ground truth is empty left out; the best figure of a column is "
        "bold, the second underlined. † sees measured depth or other sensors, ‡ sees the ground truth. "
        "Baselines start from the first model's visible ground and depth.",
        "",
        f"- footprints-edge {settings['version']}, {settings['runtime']}",
        *(f"- {row}: sha256 {sha256}" for row, sha256 in settings["models"].items()),
        *(f"- {name}: {kind}" for name, kind in settings["datasets"].items()),
        f"- options: {json.dumps({k: settings[k] for k in sorted(settings) if k in _OPTIONS})}",
        *(f"- skipped {name}: {reason}" for name, reason in failures.items()),
    ]
    return "\n".join(lines)


_OPTIONS = ("frames", "held_out", "every", "walkable", "void")


def _csv(benchmark: Benchmark, results: Results, order: Sequence[str]) -> str:
    """One line an image and row; empty where there is no score."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    columns = [(part, measure) for part, measures in MEASURES.items() for measure in measures]
    writer.writerow(["image", "method", *(f"{part}_{measure}" for part, measure in columns)])
    for item in benchmark.items():
        scores = results.images.get(item.name, {})
        for row in order:
            if row in scores:
                writer.writerow([item.name, row, *(_value(scores[row], *c) for c in columns)])
    return file.getvalue()


def _value(scores: MethodScores, part: str, measure: str) -> float | None:
    found = getattr(scores, part)
    return None if found is None else plain(getattr(found, measure))


def _worst(benchmark: Benchmark, results: Results) -> list[Example]:
    """The images whose freespace the first model finds worst; visible ground where that is all."""
    row = next(iter(benchmark.models))
    items = {item.name: item for item in benchmark.items() if item.name in results.images}
    for part in ("freespace", "visible_ground"):
        ious = {name: _value(results.images[name][row], part, "iou") for name in items}
        scored = sorted((iou, name) for name, iou in ious.items() if iou is not None)
        if scored:
            worst = [name for _, name in scored[:WORST]]
            return [_example(benchmark, items[name], results.images[name][row]) for name in worst]
    return []


def _example(benchmark: Benchmark, item: Item, scores: MethodScores) -> Example:
    ground_truth = item.load()
    model = next(iter(benchmark.models.values()))
    prediction = model.predict(ground_truth.image, intrinsics=ground_truth.intrinsics)
    figures = {
        "freespace IoU": _value(scores, "freespace", "iou"),
        "footprint IoU": _value(scores, "footprint", "iou"),
        "visible ground IoU": _value(scores, "visible_ground", "iou"),
        "hidden depth a1": _value(scores, "ground_depth", "a1"),
    }
    said = [f"{what} {value:.2f}" for what, value in figures.items() if value is not None]
    title = "     ".join([item.name, *said])
    return Example(title, prediction.rgb, ground_truth, estimate_of(prediction, ground_truth.size))


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
