"""Folders of real photos, preprocessed as the runtime would for a network."""

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
"""One photo in five is held out from the calibration, to judge it."""


def list_photos(folder: Path, at_least: int) -> list[Path]:
    """Photos of a folder and its sub-folders, sorted.

    Raises:
        ExportError: no such folder, or fewer photos than needed.
        ImageError: a folder without any image.
    """
    if not folder.is_dir():
        raise ExportError(f"{folder}: no such folder of photos")
    paths = image_files(folder, recursive=True, skip_endings=OUTPUT_ENDINGS)
    if len(paths) < at_least:
        raise ExportError(f"{folder}: {len(paths)} photos, at least {at_least} are needed")
    return paths


def spread(paths: list[Path], most: int) -> list[Path]:
    """At most ``most`` of the paths, evenly spread."""
    return paths if len(paths) <= most else [paths[i * len(paths) // most] for i in range(most)]


def split_photos(folders: Sequence[Path]) -> tuple[list[Path], list[Path]]:
    """Photos to calibrate on, and one in five held out; all folders are sampled alike.

    Raises:
        ExportError: no such folder, or fewer photos than needed.
        ImageError: a folder without any image.
    """
    calibration: list[Path] = []
    held_out: list[Path] = []
    for folder in folders:
        most = max(HELD_OUT_EVERY, MOST_CALIBRATION_PHOTOS // len(folders))
        photos = spread(list_photos(folder, at_least=HELD_OUT_EVERY), most)
        for index, photo in enumerate(photos, 1):
            (held_out if index % HELD_OUT_EVERY == 0 else calibration).append(photo)
    return calibration, held_out


def network_inputs(paths: Sequence[Path], model: Model) -> list[NDArray[np.uint8]]:
    """Preprocess photos as the runtime does, to uint8 (1, H, W, 3) each.

    Args:
        paths: image files; one that cannot be read is named in a warning and left out.
        model: the model that decides on size and filter.

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
