"""The accuracy benchmark: models and the paper's baselines on datasets with ground truth."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any

from footprints_edge.engines.onnxruntime_engine import runtime
from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.version import __version__
from footprints_edge.geometry.ground_plane import FLAT
from footprints_edge.model import Model, load
from footprints_edge.prediction import Prediction
from footprints_edge_bench.accuracy.results import ImageScores, Results
from footprints_edge_bench.accuracy.scoring import score
from footprints_edge_bench.foundation.fingerprint import (
    fingerprint,
    sha256_of_bytes,
    sha256_of_file,
)
from footprints_edge_bench.geometry.boxes import Box, read_boxes
from footprints_edge_bench.geometry.voxels import VoxelGrid, read_voxels
from footprints_edge_bench.ground_truth.base import EvaluationDataset, GroundTruth, Item
from footprints_edge_bench.ground_truth.datasets import ReadingOptions, Subset, open_datasets

UNFLATTENED = ", not flattened"
"""Suffix of the rows whose ground depth is as the network predicts it."""


class AccuracyError(FootprintsError):
    """A benchmark cannot be run as requested."""


@dataclass(frozen=True)
class BaselineInputs:
    """Predictions of other methods, for the baselines that need them.

    Attributes:
        boxes: boxes by image name.
        boxes_file: the file that they come from; None if there is none.
        voxels: folder of ``NAME.npz``; None if there is none.
    """

    boxes: Mapping[str, tuple[Box, ...]] = field(default_factory=dict)
    boxes_file: Path | None = None
    voxels: Path | None = None

    def boxes_of(self, name: str, ground_truth: GroundTruth) -> tuple[Box, ...] | None:
        """Boxes of an image: the given ones, else those of the dataset."""
        return self.boxes.get(name, ground_truth.boxes)

    def voxels_of(self, name: str, ground_truth: GroundTruth) -> VoxelGrid | None:
        """Voxels of an image, likewise; a missing file counts as a failed prediction."""
        if self.voxels is None:
            return ground_truth.voxels
        path = self.voxel_file(self.voxels, name)
        return read_voxels(path) if path.is_file() else None

    @staticmethod
    def voxel_file(folder: Path, name: str) -> Path:
        """Where the voxels of an image are."""
        return folder / f"{name}.npz"


@dataclass(frozen=True)
class Benchmark:
    """The methods to evaluate and the data to evaluate them on.

    Attributes:
        datasets: datasets with the images to score.
        models: models by the names of their rows; baselines start from the first one.
        inputs: inputs of some baselines.
        options: how the datasets were read, as plain values.
        unflattened: whether each model has a second row, with the ground depth that the network
            predicts instead of the one laid onto the ground plane.
    """

    datasets: tuple[EvaluationDataset, ...]
    models: Mapping[str, Model]
    inputs: BaselineInputs = field(default_factory=BaselineInputs)
    options: Mapping[str, Any] = field(default_factory=dict)
    unflattened: bool = False

    def settings(self) -> dict[str, Any]:
        """Everything that the scores depend on, as plain values.

        Ground-truth files and voxel files count by name, size and modification time. Images do
        not, so an image that failed can be repaired without losing the other scores.
        """
        items = self.items()
        sources = chain.from_iterable(dict.fromkeys(item.files for item in items))
        boxes, voxels = self.inputs.boxes_file, self.inputs.voxels
        return {
            "version": __version__,
            "runtime": runtime(),
            "models": {row: model.sha256 for row, model in self.models.items()},
            "datasets": {each.name: each.kind for each in self.datasets},
            "images": sha256_of_bytes("\n".join(item.name for item in items).encode()),
            "ground_truth": fingerprint(sources),
            "boxes": None if boxes is None else sha256_of_file(boxes),
            "voxels": None
            if voxels is None
            else fingerprint(self.inputs.voxel_file(voxels, item.name) for item in items),
            "flat": FLAT,
            **self.options,
            **({"unflattened": True} if self.unflattened else {}),
        }

    def items(self) -> list[Item]:
        """The images of all datasets."""
        return [item for dataset in self.datasets for item in dataset.items]

    def predict(self, ground_truth: GroundTruth) -> dict[str, Prediction]:
        """The prediction of every model for an image, by the name of its row."""
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
        """The names of the models' rows, in order."""
        suffixes = ("", UNFLATTENED) if self.unflattened else ("",)
        return [row + suffix for suffix in suffixes for row in self.models]


def open_benchmark(
    folders: Sequence[Path],
    subset: Subset,
    models: Sequence[str] | None,
    *,
    reading: ReadingOptions | None = None,
    boxes_file: Path | None = None,
    voxels: Path | None = None,
    unflattened: bool = False,
) -> Benchmark:
    """Opens datasets and loads models.

    Args:
        folders: the datasets.
        subset: their images to score.
        models: model files or registered names; the bundled model if there are none.
        reading: facts that some datasets need; None if there are none.
        boxes_file: boxes for the box baseline, see ``geometry.boxes.read_boxes``.
        voxels: folder of voxel grids for the voxel baselines.
        unflattened: see :class:`Benchmark`.

    Raises:
        AccuracyError: two models would have the same row, or the folder of voxels is missing.
        BoxesError: the file of boxes cannot be read.
        GroundTruthError: a dataset cannot be opened.
        ModelError: a model cannot be loaded.
    """
    reading = reading or ReadingOptions()
    if voxels is not None and not voxels.is_dir():
        raise AccuracyError(f"{voxels}: no such folder of voxels; give one with --voxels")
    return Benchmark(
        open_datasets(folders, reading, subset),
        name_models([load(name) for name in models] if models else [load()]),
        BaselineInputs({} if boxes_file is None else read_boxes(boxes_file), boxes_file, voxels),
        {
            "frames": subset.shares,
            "every": subset.every,
            "held_out": subset.held_out,
            "walkable": list(reading.walkable),
            "void": list(reading.void),
        },
        unflattened,
    )


def name_models(models: Sequence[Model]) -> dict[str, Model]:
    """Models by the names of their rows.

    Raises:
        AccuracyError: two models would have the same row.
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
        benchmark: what to evaluate.
        results: results of earlier runs with the same settings; new ones are added image by image.
        progress: called with the name of each image when it is done.

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
            except Exception as error:  # one bad image must not stop the others
                failures[item.name] = f"{type(error).__name__}: {error}"
        progress(item.name)
    return failures


def _score_item(benchmark: Benchmark, item: Item) -> ImageScores:
    ground_truth = item.load()
    return score(
        benchmark.predict(ground_truth),
        ground_truth,
        item.name,
        benchmark.inputs.boxes_of(item.name, ground_truth),
        benchmark.inputs.voxels_of(item.name, ground_truth),
    )
