"""Finding the picture that belongs to a truth file."""

from pathlib import Path

from footprints_edge.inputs.image_files import IMAGE_SUFFIXES
from footprints_edge_bench.ground_truth.base import TruthError


def picture_named(folder: Path, stem: str) -> Path:
    """The picture in a folder with a name, whatever its format.

    Raises:
        TruthError: there is none.
    """
    for path in sorted(folder.glob(f"{stem}.*")):
        if path.suffix.lower() in IMAGE_SUFFIXES:
            return path
    raise TruthError(f"{folder}: no picture named {stem}; put it there, as .jpg or .png")
