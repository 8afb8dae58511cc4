"""The published annotations of KITTI's Eigen test split (paper, section "Evaluation on KITTI").

``XXXXX_ground.png`` is the polygon of walkable surface, seen and hidden; ``XXXXX_objects.png`` the
footprints within it; ``XXXXX_combined.png`` the one without the other: the true ground.
"""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image

from footprints_edge.foundation.types import Mask
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_bench.ground_truth.base import (
    GroundTruth,
    GroundTruthError,
    Item,
    LabelledMask,
)
from footprints_edge_bench.ground_truth.pictures import picture_named

_FOCAL_SHARES = (0.58, 1.92)
"""Focal lengths of KITTI's colour cameras over width and height, as published training has them."""


def is_kitti_folder(folder: Path) -> bool:
    """Whether a folder holds the annotations."""
    return next(folder.glob("*_combined.png"), None) is not None


def read_kitti(folder: Path, images: Path | None) -> Iterator[Item]:
    """The annotated images.

    Args:
        folder: of the annotations.
        images: a folder of pictures ``XXXXX.*``; or a text file that lists the pictures of the
            split in order, one a line: paths relative to the file's own folder, or
            ``DRIVE FRAME l|r`` as lists of the Eigen split have it.

    Raises:
        GroundTruthError: the pictures are not there.
    """
    if images is None:
        raise GroundTruthError(
            f"{folder} holds KITTI annotations without pictures; give --images a folder of "
            "XXXXX.png, or the text file that lists the test split, in the folder of the raw data"
        )
    picture: Callable[[str], Path]
    if images.is_dir():
        picture = partial(picture_named, images)
    else:
        picture = partial(_listed, images, images.read_text(encoding="utf-8").splitlines())
    for path in sorted(folder.glob("*_combined.png")):
        number = path.name.removesuffix("_combined.png")
        yield Item(number, partial(_load, folder, number, picture))


def _load(folder: Path, number: str, picture: Callable[[str], Path]) -> GroundTruth:
    combined = _mask(folder / f"{number}_combined.png")
    region = _mask(folder / f"{number}_ground.png")
    if combined.shape != region.shape:
        raise GroundTruthError(
            f"{folder}: the masks of {number} are {combined.shape} and {region.shape}"
        )
    image = picture(number)
    with Image.open(image) as opened:
        width, height = opened.size
    fx, fy = _FOCAL_SHARES[0] * width, _FOCAL_SHARES[1] * height
    return GroundTruth(
        image,
        (combined.shape[0], combined.shape[1]),
        Intrinsics(fx, fy, (width - 1) / 2, (height - 1) / 2),
        ground=LabelledMask(combined, np.ones_like(combined)),
        region=region,
    )


def _mask(path: Path) -> Mask:
    return np.asarray(Image.open(path).convert("L")) > 128


def _listed(path: Path, lines: list[str], number: str) -> Path:
    """The picture of a number, from the list of the split."""
    if not number.isdigit() or int(number) >= len(lines):
        raise GroundTruthError(
            f"{path}: lists {len(lines)} pictures, none for the annotation {number}"
        )
    words = lines[int(number)].split()
    if len(words) == 3 and words[2] in {"l", "r"}:
        drive, frame, side = words
        camera = "image_02" if side == "l" else "image_03"
        return picture_named(path.parent / drive / camera / "data", f"{int(frame):010d}")
    return path.parent / lines[int(number)].strip()
