"""Pictures that show no ground, seen or hidden: walls, ceilings, sky, close-ups.

They are put together from what is there, always the same ones:

- of a dataset with ground truth, the largest window of a picture that has no ground in it;
- of a folder of textures with ``index.json``, those for walls;
- of a folder of panoramas with ``index.json``, views upwards that end above the horizon;
- of any other folder, the pictures as they are: they are said to show none.
"""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from footprints_edge.foundation.types import Mask, Rgb
from footprints_edge_bench.ground_truth.base import GroundTruth, GroundTruthError, Item
from footprints_edge_bench.ground_truth.datasets import KINDS, ReadingOptions, Subset, open_folder

INDEX = "index.json"
_SHAPE = 4, 3
"""Width and height of a window."""

_LEAST_SIDE = 0.35
"""Least width of a window, as a share of the picture's."""

_MARGIN_PX = 4
"""Of the ground's outline, which people and machines draw a little wrong."""

_UP_DEG, _FOV_DEG, _VIEWS = 42.0, 60.0, 6
"""Views of panoramas: pitch, horizontal field of view, and how many there are of each. The lowest
ray of the picture is 18 degrees above the horizon."""


@dataclass(frozen=True)
class PictureWithoutGround:
    """One picture; it is read on demand.

    Attributes:
        name: name of the folder, slash, name of the picture.
        load: reads it: uint8 (H, W, 3), or None if the picture has no large window without ground.
    """

    name: str
    load: Callable[[], Rgb | None] = field(repr=False)


def read_without_ground(
    folder: Path, reading: ReadingOptions, subset: Subset
) -> list[PictureWithoutGround]:
    """The pictures of a folder that show no ground, by what the folder holds.

    Raises:
        GroundTruthError: there is none.
    """
    if any(kind.recognises(folder) for kind in KINDS.values()):
        return [
            PictureWithoutGround(item.name, partial(_window_of, item, dataset.kind))
            for dataset in open_folder(folder, reading, subset)
            for item in dataset.items
        ]
    if (folder / INDEX).is_file():
        found = list(_textures_and_panoramas(folder))
    else:
        files = sorted(path for path in folder.glob("*.*") if path.suffix.lower() in _PICTURES)
        found = [PictureWithoutGround(_named(folder, path), partial(_read, path)) for path in files]
    found = list(subset.of_sequence(found))
    if not found:
        raise GroundTruthError(f"{folder}: no picture without ground is left in the requested part")
    return found


_PICTURES = {".jpg", ".jpeg", ".png", ".webp"}


def largest_window(ground: Mask) -> tuple[slice, slice] | None:
    """The largest window of the shape 4:3 without ground.

    Args:
        ground: bool (H, W).

    Returns:
        Rows and columns; None if the largest one is narrower than `_LEAST_SIDE` of the picture.
    """
    height, width = ground.shape
    sums = np.pad(ground.astype(np.int64).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    for columns in range(min(width, height * _SHAPE[0] // _SHAPE[1]), 0, -8):
        if columns < _LEAST_SIDE * width:
            return None
        rows = columns * _SHAPE[1] // _SHAPE[0]
        within = sums[rows:, columns:] - sums[:-rows, columns:]
        within = within - sums[rows:, :-columns] + sums[:-rows, :-columns]
        empty = np.flatnonzero(within.ravel() == 0)
        if empty.size:
            top, left = divmod(int(empty[len(empty) // 2]), within.shape[1])
            return slice(top, top + rows), slice(left, left + columns)
    return None


def _window_of(item: Item, kind: str) -> Rgb | None:
    ground_truth = item.load()
    window = largest_window(_grown(_may_be_ground(ground_truth, kind)))
    if window is None:
        return None
    picture = _read(ground_truth.image)
    y, x = (side / of for side, of in zip(picture.shape[:2], ground_truth.size, strict=True))
    rows, columns = window
    return picture[
        round(rows.start * y) : round(rows.stop * y),
        round(columns.start * x) : round(columns.stop * x),
    ].copy()


def _may_be_ground(ground_truth: GroundTruth, kind: str) -> Mask:
    """Bool (H, W): where a ray may meet ground, seen or hidden."""
    if ground_truth.ground is not None:
        may_be = ground_truth.ground.mask
        # what is not scored in synthetic scenes is ground of the next room, behind a wall
        return may_be if kind == "synthetic scenes" else may_be | ~ground_truth.ground.valid
    visible = ground_truth.visible_ground
    if visible is None:
        raise GroundTruthError(f"{ground_truth.image}: nothing says where its ground is")
    # hidden ground is lower than the highest that is seen, almost always
    seen = np.logical_or.accumulate(visible.mask.any(axis=1))
    return seen[:, None] | ~visible.valid


def _grown(mask: Mask) -> Mask:
    grown = mask.copy()
    for _ in range(_MARGIN_PX):
        grown[1:] |= grown[:-1]
        grown[:-1] |= grown[1:]
    return grown


def _textures_and_panoramas(folder: Path) -> Iterator[PictureWithoutGround]:
    path = folder / INDEX
    try:
        entries: Sequence[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))
        files = sorted(
            (folder / each["file"], each.get("use", ""), each.get("projection", ""))
            for each in entries
        )
    except (ValueError, KeyError, TypeError) as error:
        raise GroundTruthError(f"{path} does not list textures or panoramas: {error!r}") from error
    for file, use, projection in files:
        if use == "wall":
            yield PictureWithoutGround(_named(folder, file), partial(_read, file))
        if projection == "equirectangular":
            for view in range(_VIEWS):
                name = f"{_named(folder, file)}_{view}"
                yield PictureWithoutGround(name, partial(_upwards, file, 360 * view / _VIEWS))


def _upwards(file: Path, heading_deg: float) -> Rgb:
    from footprints_edge.geometry.camera import Intrinsics
    from footprints_edge_models.asset_files.asset import Credit
    from footprints_edge_models.panoramas.labels import Panorama
    from footprints_edge_models.panoramas.views import PanoramaCamera, cut_picture

    image, credit = _read(file), Credit(file.stem, "", "", str(file))
    size = (384, 512)
    camera = PanoramaCamera(size, Intrinsics.from_hfov(_FOV_DEG, size), heading_deg, _UP_DEG, 0.0)
    return cut_picture(
        Panorama(file.stem, image, np.zeros(image.shape[:2], np.uint8), credit), camera
    )


def _named(folder: Path, file: Path) -> str:
    return f"{folder.resolve().name}/{file.relative_to(folder).with_suffix('').as_posix()}"


def _read(file: Path) -> Rgb:
    try:
        with Image.open(file) as opened:
            return np.asarray(opened.convert("RGB"))
    except OSError as error:
        raise GroundTruthError(f"{file}: not a readable picture: {error}") from error
