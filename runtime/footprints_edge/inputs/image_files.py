"""The pictures in a folder."""

from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

from footprints_edge.errors import ImageError
from footprints_edge.inputs.foreign_files import AVIF_SUFFIXES, HEIF_SUFFIXES, UNREAD_SUFFIXES
from footprints_edge.inputs.images import reads_avif, reads_heif

IMAGE_SUFFIXES = frozenset(
    {".jpg", ".jpeg", ".jfif", ".jpe", ".png", ".webp", ".tif", ".tiff", ".bmp"}
)
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
    suffixes = readable_suffixes()
    found = [
        path
        for path in _shown_files(folder, recursive=recursive)
        if path.suffix.lower() in suffixes and not path.name.lower().endswith(skipped)
    ]
    if not found:
        hint = "" if recursive else "; --recursive searches its sub-folders too"
        raise ImageError(
            f"{folder}: no picture in this folder ({', '.join(sorted(suffixes))}){hint}"
        )
    return found


def readable_suffixes() -> frozenset[str]:
    """`IMAGE_SUFFIXES`, and those of formats that need a package which is installed."""
    more = HEIF_SUFFIXES if reads_heif() else frozenset()
    return IMAGE_SUFFIXES | more | (AVIF_SUFFIXES if reads_avif() else frozenset())


def passed_over(folder: Path, *, recursive: bool = False) -> str:
    """Says which pictures of a folder `image_files` does not list, such as `2 .heic, 1 .dng`.

    Links that lead nowhere are among them. Empty if there are none.
    """
    unread = UNREAD_SUFFIXES - readable_suffixes()
    kinds = Counter(
        path.suffix.lower()
        for path in _shown_files(folder, recursive=recursive)
        if path.suffix.lower() in unread
    )
    lost = sum(
        path.suffix.lower() in IMAGE_SUFFIXES and path.is_symlink() and not path.exists()
        for path in (folder.rglob("*") if recursive else folder.iterdir())
    )
    said = [f"{count} {kind}" for kind, count in kinds.most_common()]
    said += ["1 link that leads nowhere"] if lost == 1 else []
    said += [f"{lost} links that lead nowhere"] if lost > 1 else []
    return ", ".join(said)


def _shown_files(folder: Path, *, recursive: bool) -> Iterator[Path]:
    for path in sorted(folder.rglob("*") if recursive else folder.iterdir()):
        if not path.name.startswith(".") and path.is_file():
            yield path
