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


def label_photos(folder: Path, output: Path, segment: Segmenter) -> Iterator[str | None]:
    """Writes ``images/NAME.jpg`` and ``labels/NAME.png`` for the photos of a folder.

    Yields:
        For each photo None, or why it was left out.

    Raises:
        DatasetError: there is no such folder.
    """
    for part in ("images", "labels"):
        (output / part).mkdir(parents=True, exist_ok=True)
    for path in list_pictures(folder):
        try:
            image = decode(path).rgb
        except ImageError as error:
            yield str(error)
            continue
        size = within((image.shape[0], image.shape[1]), LONGEST_SIDE_PX)
        if size != image.shape[:2]:
            image = resized(image, size)
        if min(size) < LEAST_SIDE_PX:
            yield f"{path}: {size[1]} x {size[0]} pixels of {LONGEST_SIDE_PX}; it is too narrow"
        elif _is_grey(image):
            yield f"{path}: it is black and white"
        else:
            _write(output, path.stem, image, nearest(segment(image), size))
            yield None


def _is_grey(image: NDArray[np.uint8]) -> bool:
    level = image.mean(axis=2, keepdims=True)
    return float(np.abs(image - level).mean()) < GREY


def _write(output: Path, name: str, image: NDArray[np.uint8], ids: NDArray[np.uint8]) -> None:
    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    flags = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
    write_atomically(
        output / "images" / f"{name}.jpg", cv2.imencode(".jpg", bgr, flags)[1].tobytes()
    )
    write_atomically(output / "labels" / f"{name}.png", cv2.imencode(".png", ids)[1].tobytes())
