"""Datasets packed for training: decoded once, then read by memory-mapping.

A dataset is two files: ``NAME.bin`` holds the arrays of all samples one after another, as they are
in memory; ``NAME.json`` says where each lies. Any number of processes share the pages.
"""

import json
import logging
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, BinaryIO, overload

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.asset_files.asset import Credit
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.mixture import TrainingDataset, load_datasets
from footprints_edge_models.sample import Sample

logger = logging.getLogger(__name__)

VERSION = 1
_ALIGNMENT = 64


class PackedSamples(Sequence[Sample]):
    """Samples of a packed dataset; their arrays are read-only views of the file."""

    def __init__(self, path: Path, rows: list[dict[str, Any]]) -> None:
        """Maps the file into memory."""
        self._path = path
        self._bytes = np.memmap(path, np.uint8, "r") if rows else np.empty(0, np.uint8)
        self._rows = rows

    def __len__(self) -> int:
        """Number of samples."""
        return len(self._rows)

    @overload
    def __getitem__(self, index: int) -> Sample: ...
    @overload
    def __getitem__(self, index: slice) -> "PackedSamples": ...
    def __getitem__(self, index: int | slice) -> "Sample | PackedSamples":
        """One sample, or for a slice some of them, still packed."""
        if isinstance(index, slice):
            return PackedSamples(self._path, self._rows[index])
        row = self._rows[index]
        values: dict[str, Any] = {
            name: self._array(*where) for name, where in row["arrays"].items()
        }
        return Sample(intrinsics=Intrinsics(**row["intrinsics"]), **row["values"], **values)

    def _array(self, offset: int, dtype: str, shape: list[int]) -> NDArray[Any]:
        kind = np.dtype(dtype)
        end = offset + kind.itemsize * int(np.prod(shape))
        return np.asarray(self._bytes[offset:end]).view(kind).reshape(shape)


@dataclass(frozen=True)
class _Index:
    version: int
    share: float
    train: list[dict[str, Any]]
    held_out: list[dict[str, Any]]
    credits: list[dict[str, str]] = field(default_factory=list)
    views: int = 1


def pack(datasets: dict[str, TrainingDataset], folder: Path) -> list[Path]:
    """Pack datasets into a folder; those that it has already are kept.

    A sample that cannot be read is left out, with a message.

    Returns:
        The paths of their indices.

    Raises:
        DatasetError: none of a dataset's samples can be read.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, dataset in datasets.items():
        index = folder / f"{name}.json"
        if not index.exists():
            part = folder / f"{name}.part"
            with part.open("wb") as file:
                train, held_out = (_write(file, s) for s in (dataset.train, dataset.held_out))
            if not train and len(dataset.train):
                raise DatasetError(f"{name}: none of its samples can be read")
            part.replace(folder / f"{name}.bin")
            facts = asdict(
                _Index(
                    VERSION,
                    dataset.share,
                    train,
                    held_out,
                    [asdict(credit) for credit in dataset.credits],
                    dataset.views,
                )
            )
            write_atomically(index, json.dumps(facts).encode())
            logger.info("%s: %d to train on, %d held out", name, len(train), len(held_out))
        written.append(index)
    return written


def datasets_in(folder: Path) -> dict[str, TrainingDataset]:
    """The datasets of a folder, packed or not.

    Raises:
        DatasetError: see :func:`load_packed` and :func:`mixture.load_datasets`.
    """
    return load_packed(folder) if is_packed(folder) else load_datasets(folder)


def is_packed(folder: Path) -> bool:
    """Whether :func:`pack` wrote into this folder."""
    return any(path.with_suffix(".bin").exists() for path in folder.glob("*.json"))


def load_packed(folder: Path) -> dict[str, TrainingDataset]:
    """The datasets that :func:`pack` wrote.

    Raises:
        DatasetError: an index is damaged or of another version, or its file too short.
    """
    datasets = {}
    for path in sorted(folder.glob("*.json")):
        try:
            index = _Index(**json.loads(path.read_bytes()))
            if index.version != VERSION:
                raise ValueError(f"version {index.version}")
            credits = tuple(Credit(**facts) for facts in index.credits)
            train, held_out = (
                PackedSamples(path.with_suffix(".bin"), rows)
                for rows in (index.train, index.held_out)
            )
            for samples in (train, held_out):
                if samples:
                    samples[len(samples) - 1]
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise DatasetError(f"{path}: damaged, pack it again: {error}") from error
        datasets[path.stem] = TrainingDataset(train, held_out, index.share, credits, index.views)
    return datasets


def _write(file: BinaryIO, samples: Iterable[Sample]) -> list[dict[str, Any]]:
    """Appends samples to a file; where each lies."""
    rows = []
    for sample in _readable(samples):
        arrays, values = {}, {}
        for each in fields(Sample):
            value = getattr(sample, each.name)
            if isinstance(value, np.ndarray):
                file.write(bytes(-file.tell() % _ALIGNMENT))
                arrays[each.name] = (file.tell(), value.dtype.str, value.shape)
                file.write(np.ascontiguousarray(value).data)
            elif each.name != "intrinsics" and value is not None:
                values[each.name] = value
        camera = asdict(sample.intrinsics)
        rows.append({"values": values, "intrinsics": camera, "arrays": arrays})
    return rows


def _readable(samples: Iterable[Sample]) -> Iterable[Sample]:
    if not isinstance(samples, Sequence):
        yield from samples
        return
    for index in range(len(samples)):
        try:
            yield samples[index]
        except (FootprintsError, OSError, ValueError) as error:
            logger.warning("left out: %s", error)
