"""Training data published with the paper, beside the raw data that it belongs to."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.sample import Sample

MOST_PUBLISHED = 3000
"""Published datasets hold tens of thousands of samples, about half a megabyte each in memory."""


def read_published(
    raw: Path, reader: Callable[[Path, Path, Iterable[str]], Iterator[Sample]]
) -> Iterator[Sample]:
    """Raw data in a folder NAME_raw, and beside it NAME_training_data, folder or zip.

    ``train.txt`` in the raw folder lists the samples. At most ``MOST_PUBLISHED`` of them, evenly
    spread, are read: all are kept in memory.

    Raises:
        DatasetError: there is no published data beside the raw data.
    """
    published = raw.with_name(raw.name.removesuffix("_raw") + "_training_data")
    packed = published.with_name(published.name + ".zip")
    if not published.is_dir() and not packed.is_file():
        raise DatasetError(f"{published}: no such folder, nor {packed.name}")
    lines = (raw / "train.txt").read_text(encoding="utf-8").splitlines()
    spread = lines[:: -(-len(lines) // MOST_PUBLISHED)] if lines else []
    return reader(raw, published if published.is_dir() else packed, spread)
