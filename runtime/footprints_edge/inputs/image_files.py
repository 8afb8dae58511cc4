"""The pictures in a folder."""

from collections.abc import Iterable
from pathlib import Path

from footprints_edge.errors import ImageError

IMAGE_SUFFIXES = frozenset({".jpg", ".jpeg", ".png", ".webp", ".tif", ".tiff", ".bmp"})
"""Suffixes of files that count as pictures in a folder. A file named directly is always read."""


def image_files(
    folder: Path, *, recursive: bool = False, skip_endings: Iterable[str] = ()
) -> list[Path]:
    """Lists the pictures in a folder, sorted, without hidden files.

    Args:
        folder: The folder to search.
        recursive: Whether to search its sub-folders too.
        skip_endings: Endings of file names to skip, such as those of our own outputs.

    Raises:
        ImageError: If the folder contains no pictures.
    """
    skipped = tuple(skip_endings)
    found = [
        path
        for path in sorted(folder.rglob("*") if recursive else folder.iterdir())
        if path.suffix.lower() in IMAGE_SUFFIXES
        and not path.name.startswith(".")
        and not path.name.lower().endswith(skipped)
        and path.is_file()
    ]
    if not found:
        hint = "" if recursive else "; --recursive searches its sub-folders too"
        raise ImageError(
            f"{folder}: no picture in this folder ({', '.join(sorted(IMAGE_SUFFIXES))}){hint}"
        )
    return found
