"""Finds the image that belongs to a ground-truth file."""

from pathlib import Path

from footprints_edge.inputs.image_files import IMAGE_SUFFIXES
from footprints_edge_bench.ground_truth.base import GroundTruthError


def image_named(folder: Path, stem: str) -> Path:
    """The image with a name in a folder, whatever its format.

    Raises:
        GroundTruthError: there is none.
    """
    for path in sorted(folder.glob(f"{stem}.*")):
        if path.suffix.lower() in IMAGE_SUFFIXES:
            return path
    raise GroundTruthError(f"{folder}: no image named {stem}; add it, as .jpg or .png")
