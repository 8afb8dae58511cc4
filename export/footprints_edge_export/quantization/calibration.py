"""A folder of real photos, as the runtime itself would feed them to a network."""

import logging
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import ImageError
from footprints_edge.inputs.image_files import image_files
from footprints_edge.inputs.preprocessing import preprocess
from footprints_edge.model import Model
from footprints_edge.outputs.writers import OUTPUT_ENDINGS
from footprints_edge_export.errors import ExportError

logger = logging.getLogger(__name__)

MOST_CALIBRATION_PHOTOS = 200
HELD_OUT_EVERY = 5
"""One calibration photo in five is kept from the calibration, to judge it."""


def list_photos(folder: Path, at_least: int) -> list[Path]:
    """Pictures of a folder and its sub-folders, sorted.

    Raises:
        ExportError: no such folder, or fewer pictures than needed.
        ImageError: no picture at all.
    """
    if not folder.is_dir():
        raise ExportError(f"{folder}: no such folder of photos")
    paths = image_files(folder, recursive=True, skip_endings=OUTPUT_ENDINGS)
    if len(paths) < at_least:
        raise ExportError(f"{folder}: {len(paths)} photos, at least {at_least} are needed")
    return paths


def spread(paths: list[Path], most: int) -> list[Path]:
    """At most so many of them, evenly spread."""
    return paths if len(paths) <= most else [paths[i * len(paths) // most] for i in range(most)]


def split_photos(folders: Sequence[Path]) -> tuple[list[Path], list[Path]]:
    """Photos to calibrate on, and one in five kept from that, each folder drawn from alike.

    Raises:
        ExportError: no such folder, or fewer pictures than needed.
        ImageError: no picture at all.
    """
    calibration: list[Path] = []
    held_out: list[Path] = []
    for folder in folders:
        most = max(HELD_OUT_EVERY, MOST_CALIBRATION_PHOTOS // len(folders))
        photos = spread(list_photos(folder, at_least=HELD_OUT_EVERY), most)
        for index, photo in enumerate(photos, 1):
            (held_out if index % HELD_OUT_EVERY == 0 else calibration).append(photo)
    return calibration, held_out


def network_inputs(paths: list[Path], model: Model) -> list[NDArray[np.uint8]]:
    """Photos through the runtime's preprocessing, uint8 (1, H, W, 3) each.

    Args:
        paths: pictures; one that cannot be read is named in a warning and left out.
        model: what they are for; it decides on size and filter.

    Raises:
        ExportError: none of them can be read.
    """
    inputs = []
    for path in paths:
        try:
            image = model.decode(path)
        except ImageError as error:
            logger.warning("left out: %s", error)
            continue
        inputs.append(preprocess(image.pixels, model.input_size(image.size), model.metadata.resize))
    if not inputs:
        raise ExportError(f"none of {len(paths)} photos can be read; the first is {paths[0]}")
    return inputs
