"""Ground that a person drew on photos, seen and hidden, as the paper did for KITTI's test images.

A folder holds ``images/`` and ``truth.json``: a list of photos with ``name``, ``kind`` (such as
``street``), ``size_wh``, and polygons in pixels: ``ground``, the walkable surface, seen and hidden;
``footprints``, the ground that things take; ``visible``, the ground that is seen; ``ignore``,
pixels that are not scored.
"""

import json
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from footprints_edge.foundation.types import Mask, Size
from footprints_edge_bench.ground_truth.base import (
    GroundTruth,
    GroundTruthError,
    Item,
    LabelledMask,
)

ANNOTATIONS = "truth.json"


def is_hand_drawn_folder(folder: Path) -> bool:
    """Whether a folder holds ``images/`` and ``truth.json``."""
    return (folder / "images").is_dir() and (folder / ANNOTATIONS).is_file()


def read_hand_drawn(folder: Path) -> Iterator[Item]:
    """The photos of a folder; their names begin with their kind: ``street/NAME``.

    Raises:
        GroundTruthError: the annotations cannot be read.
    """
    path = folder / ANNOTATIONS
    try:
        photos = json.loads(path.read_text(encoding="utf-8"))
        named = [(f"{photo['kind']}/{photo['name']}", photo) for photo in photos]
    except (ValueError, KeyError, TypeError) as error:
        raise GroundTruthError(f"{path} is not a list of annotated photos: {error!r}") from error
    for name, photo in sorted(named, key=lambda each: each[0]):
        yield Item(name, partial(_load, folder, photo), (path,))


def _load(folder: Path, photo: Mapping[str, Any]) -> GroundTruth:
    image = folder / "images" / photo["name"]
    if not image.is_file():
        raise GroundTruthError(f"{image}: no such image, but {ANNOTATIONS} annotates it")
    width, height = photo["size_wh"]
    size = (int(height), int(width))
    ground, footprints, visible, ignored = (
        _filled(photo.get(part, ()), size) for part in ("ground", "footprints", "visible", "ignore")
    )
    return GroundTruth(
        image,
        size,
        visible_ground=LabelledMask(visible & ~footprints & ~ignored, ~ignored),
        ground=LabelledMask(ground & ~footprints & ~ignored, ~ignored),
        region=(ground | footprints) & ~ignored,
        footprints=footprints & ~ignored,
    )


def _filled(polygons: Any, size: Size) -> Mask:  # noqa: ANN401 - from JSON
    """Bool (H, W): pixels whose centre, at half a pixel, lies in any of the polygons."""
    from skimage.draw import polygon2mask

    mask = np.zeros(size, bool)
    for polygon in polygons:
        if len(polygon) > 2:
            mask |= polygon2mask(size, np.asarray(polygon, np.float64)[:, ::-1] - 0.5)
    return mask
