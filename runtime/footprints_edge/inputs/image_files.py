"""The pictures in a folder."""

from collections.abc import Iterable
from pathlib import Path

from footprints_edge.errors import ImageError

IMAGE_SUFFIXES = frozenset({".jpg", ".jpeg", ".png", ".webp", ".tif", ".tiff", ".bmp"})
"""File suffixes that count as pictures in a folder. A file named outright is always tried."""


def image_files(
    folder: Path, *, recursive: bool = False, skip_endings: Iterable[str] = ()
) -> list[Path]:
    """The pictures in a folder, sorted, without hidden files.

    Args:
        folder: The folder.
        recursive: Whether its sub-folders count.
        skip_endings: Endings of file names to leave out, such as those of our own outputs.

    Raises:
        ImageError: If the folder holds no picture.
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
        hint = "" if recursive else "; --recursive looks in its sub-folders too"
        raise ImageError(
            f"{folder}: no picture in this folder ({', '.join(sorted(IMAGE_SUFFIXES))}){hint}"
        )
    return found
