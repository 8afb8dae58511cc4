"""Training data published with the paper, beside the raw data that it belongs to."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.sample import Sample

MOST_PUBLISHED = 3000
"""Samples taken of a published data set of tens of thousands: about half a megabyte each."""


def read_published(
    raw: Path, reader: Callable[[Path, Path, Iterable[str]], Iterator[Sample]]
) -> Iterator[Sample]:
    """Raw data in a folder NAME_raw, and beside it NAME_training_data, folder or zip.

    Of the split in ``train.txt`` in the raw folder, evenly spread lines are taken: all samples are
    kept in memory.
    """
    published = raw.with_name(raw.name.removesuffix("_raw") + "_training_data")
    packed = published.with_name(published.name + ".zip")
    if not published.is_dir() and not packed.is_file():
        raise DatasetError(f"{published}: no such folder, nor {packed.name}")
    lines = (raw / "train.txt").read_text(encoding="utf-8").splitlines()
    spread = lines[:: -(-len(lines) // MOST_PUBLISHED)] if lines else []
    return reader(raw, published if published.is_dir() else packed, spread)
