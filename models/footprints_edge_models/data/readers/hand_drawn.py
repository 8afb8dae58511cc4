"""Photos on which a person drew the ground, seen and hidden: to calibrate on, not to train on.

A folder holds ``images/`` and ``truth.json``, a list of photos with ``name``, ``kind``,
``size_wh``, and polygons in pixels: ``ground``, ``visible``, ``footprints``, ``ignore``, as those
of panoramas (:mod:`panoramas.labels`).
"""

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import decode
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.panoramas.labels import (
    FOOTPRINT,
    GROUND,
    IGNORED,
    LABEL_SCALE,
    VISIBLE_GROUND,
    drawn_bits,
)
from footprints_edge_models.sample import FOOTPRINT as TAKEN
from footprints_edge_models.sample import NO, UNKNOWN, YES, Sample, nearest, shrunk

ANNOTATIONS = "truth.json"


def is_hand_drawn(folder: Path) -> bool:
    """Whether a folder holds ``images/`` and ``truth.json``."""
    return (folder / "images").is_dir() and (folder / ANNOTATIONS).is_file()


def read_hand_drawn(folder: Path) -> Iterator[Sample]:
    """The photos of a folder, by kind: S and S* are labelled but where nobody can decide.

    Raises:
        DatasetError: the annotations, or a photo, cannot be read.
    """
    path = folder / ANNOTATIONS
    try:
        photos = json.loads(path.read_text(encoding="utf-8"))
        for photo in sorted(photos, key=lambda each: (each["kind"], each["name"])):
            width, height = photo["size_wh"]
            stated = {**photo, "width": width, "height": height}
            fine = drawn_bits(stated, (int(height), int(width)))
            bits = nearest(fine, (fine.shape[0] // LABEL_SCALE, fine.shape[1] // LABEL_SCALE))
            image = decode(folder / "images" / photo["name"]).rgb
            if image.shape[:2] != bits.shape:
                raise DatasetError(f"{photo['name']}: not of the size that {path} states")
            ignored = bits & IGNORED > 0
            visible = np.where(bits & VISIBLE_GROUND > 0, YES, NO)
            ground = np.select([bits & GROUND > 0, bits & FOOTPRINT > 0], [YES, TAKEN], NO)
            yield shrunk(
                Sample(
                    f"{folder.name}/{photo['name']}",
                    image,
                    Intrinsics.assumed(bits.shape),
                    np.where(ignored, UNKNOWN, visible).astype(np.uint8),
                    np.where(ignored, UNKNOWN, ground).astype(np.uint8),
                )
            )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise DatasetError(f"{path}: no readable list of annotated photos ({error!r})") from error
