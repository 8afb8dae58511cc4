"""Finding the picture that belongs to a ground truth file."""

from pathlib import Path

from footprints_edge.cli.sources import SUFFIXES
from footprints_edge_bench.ground_truth.base import GroundTruthError


def picture_named(folder: Path, stem: str) -> Path:
    """The picture in a folder with a name, whatever its format.

    Raises:
        GroundTruthError: there is none.
    """
    for path in sorted(folder.glob(f"{stem}.*")):
        if path.suffix.lower() in SUFFIXES:
            return path
    raise GroundTruthError(f"{folder}: no picture named {stem}; put it there, as .jpg or .png")
