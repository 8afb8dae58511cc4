"""Labelled photos: people drew the walkable surface that is visible; nothing hidden is known."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image

from footprints_edge_bench.ground_truth.base import (
    GroundTruth,
    GroundTruthError,
    Item,
    LabelledMask,
)
from footprints_edge_bench.ground_truth.find_image import image_named


def is_photo_folder(folder: Path) -> bool:
    """Whether a folder holds ``images/`` and ``labels/``."""
    return (folder / "images").is_dir() and (folder / "labels").is_dir()


def read_photos(folder: Path, walkable: tuple[int, ...], void: tuple[int, ...]) -> Iterator[Item]:
    """Photos in ``images/`` with class ids of the same name in ``labels/*.png``.

    Args:
        folder: holds both folders.
        walkable: class ids of ground.
        void: class ids that are not scored.

    Raises:
        GroundTruthError: no class is walkable, or there are no labels.
    """
    if not walkable:
        raise GroundTruthError(
            f"{folder} holds labelled photos; name the class ids of ground, such as "
            "--walkable 3,4, and those that are not scored, such as --void 11"
        )
    labels = sorted((folder / "labels").glob("*.png"))
    if not labels:
        raise GroundTruthError(f"{folder / 'labels'}: no label images; add PNGs of class ids")
    for path in labels:
        yield Item(path.stem, partial(_load, folder, path, walkable, void), (path,))


def _load(
    folder: Path, path: Path, walkable: tuple[int, ...], void: tuple[int, ...]
) -> GroundTruth:
    image = image_named(folder / "images", path.stem)
    ids = np.asarray(Image.open(path))
    if ids.ndim != 2:
        raise GroundTruthError(
            f"{path}: labels have shape {ids.shape}; save class ids in one channel"
        )
    valid = ~np.isin(ids, void)
    mask = np.isin(ids, walkable) & valid
    size = (ids.shape[0], ids.shape[1])
    return GroundTruth(image, size, visible_ground=LabelledMask(mask, valid))
