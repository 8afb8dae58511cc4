"""Labels photos by a segmenter: a dataset that :func:`read_photos` reads."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import ImageError
from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge.inputs.images import decode
from footprints_edge.inputs.preprocessing import resized
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.readers.pictures import list_pictures
from footprints_edge_models.sample import nearest, within
from footprints_edge_models.segmenter import Segmenter

LONGEST_SIDE_PX = 640
LEAST_SIDE_PX = 300
"""Of the shrunk photo: a narrower one is a strip, or was small."""
GREY = 2.0
"""Mean difference of the colours from their mean, in levels of 255, below which a photo is black
and white."""
_JPEG_QUALITY = 88


def label_photos(
    folder: Path, output: Path, segment: Segmenter
) -> Iterator[str | ImageError | None]:
    """Writes ``images/NAME.jpg`` and ``labels/NAME.png`` for the photos of a folder.

    Those that are there are kept.

    Yields:
        For each photo None, or why it was left out, or the error where it cannot be read.

    Raises:
        DatasetError: there is no such folder, or no photo in it.
    """
    paths = list_pictures(folder)
    if not paths:
        raise DatasetError(f"{folder}: no photos in it")
    for part in ("images", "labels"):
        (output / part).mkdir(parents=True, exist_ok=True)
    names: set[str] = set()
    for path in paths:
        if path.stem in names:
            yield f"{path}: there is another photo of this name"
            continue
        names.add(path.stem)
        if (output / "images" / f"{path.stem}.jpg").is_file():
            yield None
            continue
        try:
            image = decode(path).rgb
        except ImageError as error:
            yield error
            continue
        yield _label(path, image, output, segment)


def _label(path: Path, image: NDArray[np.uint8], output: Path, segment: Segmenter) -> str | None:
    """Labels a photo; returns why not."""
    size = within((image.shape[0], image.shape[1]), LONGEST_SIDE_PX)
    if size != image.shape[:2]:
        image = resized(image, size)
    if min(size) < LEAST_SIDE_PX:
        return f"{path}: {size[1]} x {size[0]} pixels of {LONGEST_SIDE_PX}; it is too narrow"
    if _is_grey(image):
        return f"{path}: it is black and white"
    labels = cv2.imencode(".png", nearest(segment(image), size))[1].tobytes()
    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    photo = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[1].tobytes()
    write_atomically(output / "labels" / f"{path.stem}.png", labels)
    write_atomically(output / "images" / f"{path.stem}.jpg", photo)  # last: then it is whole
    return None


def _is_grey(image: NDArray[np.uint8]) -> bool:
    level = image.mean(axis=2, keepdims=True)
    return float(np.abs(image - level).mean()) < GREY
