"""Panoramas with ground that a person drew on them, as masks.

A folder holds ``index.json`` (see :mod:`asset_files.pictures`), the panoramas, and
``labels/NAME.json`` with lists of polygons: ``ground``, the walkable surface, seen and hidden;
``visible``, what is seen of it; ``footprints``, what things take of it; ``ignore``, pixels that
nobody can decide. Polygons are in pixels of the panorama whose ``width`` and ``height`` stand
beside them; whole numbers are the edges of pixels.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import FootprintsError
from footprints_edge_models.asset_files.asset import AssetError, Credit
from footprints_edge_models.asset_files.pictures import PictureFile, panorama_files
from footprints_edge_models.bounded_files import decode_picture

VISIBLE_GROUND, GROUND, FOOTPRINT, IGNORED = 1, 2, 4, 8
"""Bits of a pixel's label: S; S*, without footprints; a footprint; not decided, no other bit."""

LABEL_SCALE = 4
"""Labels are drawn at this many times the panorama's size: outlines are good to a part of a pixel,
and a view enlarges them."""

_MOST_SHIFT_BITS = 4
_CLASSES = ("ground", "visible", "footprints", "ignore")


class PanoramaError(FootprintsError):
    """A panorama or its labels cannot be used."""


@dataclass(frozen=True)
class Panorama:
    """An equirectangular picture, level, and its labels.

    Column 0 looks along azimuth 0, columns go right; row 0 is straight up.

    Attributes:
        name: name of its file, without suffix.
        image: uint8 (H, 2 H, 3), RGB.
        bits: uint8 (``LABEL_SCALE`` H, ``LABEL_SCALE`` 2 H), a combination of VISIBLE_GROUND and
            its companions.
        credit: whom to credit.
    """

    name: str
    image: NDArray[np.uint8] = field(repr=False)
    bits: NDArray[np.uint8] = field(repr=False)
    credit: Credit


def find_panoramas(assets: Path) -> Path:
    """The folder of labelled panoramas in a folder of assets, or that folder itself.

    Raises:
        PanoramaError: there is none.
    """
    for folder in (assets, assets / "panoramas"):
        if (folder / "index.json").is_file() and (folder / "labels").is_dir():
            return folder
    raise PanoramaError(
        f"{assets}: no labelled panoramas here, nor in {assets / 'panoramas'}; a folder with "
        "index.json, the panoramas and labels/*.json is needed"
    )


def read_panoramas(folder: Path) -> Iterator[Panorama | PanoramaError]:
    """The labelled panoramas of a folder; in place of one that cannot be used, why.

    Those without a label file, or without any ground on it, are no part of it.
    """
    try:
        files = list(panorama_files(folder / "index.json"))
    except (OSError, ValueError, TypeError) as error:
        raise PanoramaError(f"{folder / 'index.json'}: not readable as JSON ({error})") from error
    for file in files:
        if isinstance(file, AssetError):
            yield PanoramaError(str(file))
            continue
        labels = folder / "labels" / f"{file.key}.json"
        if labels.is_file():
            try:
                panorama = _panorama(file, labels)
            except PanoramaError as error:
                yield error
            else:
                if (panorama.bits & GROUND).any():
                    yield panorama


def _panorama(file: PictureFile, labels: Path) -> Panorama:
    try:
        encoded = decode_picture(file.jpeg)
    except ValueError as error:
        raise PanoramaError(f"{file.key}: {error}") from error
    if encoded.shape[1] != 2 * encoded.shape[0]:
        raise PanoramaError(f"{file.key}: not a picture twice as wide as high")
    try:
        stated = json.loads(labels.read_text(encoding="utf-8"))
        bits = drawn_bits(stated, (encoded.shape[0], encoded.shape[1]))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise PanoramaError(f"{labels}: no readable polygons ({error!r})") from error
    return Panorama(file.key, cv2.cvtColor(encoded, cv2.COLOR_BGR2RGB), bits, file.credit)


def drawn_bits(stated: Mapping[str, Any], size: tuple[int, int]) -> NDArray[np.uint8]:
    """Labels of a panorama from its polygons, uint8 (``LABEL_SCALE`` H, ``LABEL_SCALE`` W).

    Args:
        stated: content of a label file.
        size: (H, W) of the panorama.
    """
    fine = (LABEL_SCALE * size[0], LABEL_SCALE * size[1])
    scale = np.array([fine[1] / stated["width"], fine[0] / stated["height"]])
    ground, visible, footprints, ignored = (
        _filled(stated.get(name, ()), scale, fine) for name in _CLASSES
    )
    taken = footprints & ~ignored
    free = ground & ~footprints & ~ignored
    bits: NDArray[np.uint8] = (
        VISIBLE_GROUND * (visible & free) + GROUND * free + FOOTPRINT * taken + IGNORED * ignored
    ).astype(np.uint8)
    return bits


def _filled(
    polygons: Any,  # noqa: ANN401 - from JSON
    scale: NDArray[np.float64],
    size: tuple[int, int],
) -> NDArray[np.bool_]:
    mask = np.zeros(size, np.uint8)
    for polygon in polygons:
        points = np.asarray(polygon, np.float64)
        if len(points) > 2:
            # OpenCV's whole numbers are the centres of pixels
            fixed = np.rint((points * scale - 0.5) * 2**_MOST_SHIFT_BITS).astype(np.int32)
            cv2.fillPoly(mask, [fixed], 1, shift=_MOST_SHIFT_BITS)
    return mask > 0
