"""The published annotations of KITTI's Eigen test split (paper, section "Evaluation on KITTI").

``XXXXX_ground.png`` outlines the walkable surface, visible and hidden. ``XXXXX_objects.png`` holds
the footprints of objects on it. ``XXXXX_combined.png`` is the first without the second: the ground.
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
from footprints_edge_bench.ground_truth.find_image import image_named

_FOCAL_SHARES = (0.58, 1.92)
"""Focal lengths of KITTI's colour cameras as shares of width and height, as in the published
training code."""


def is_kitti_folder(folder: Path) -> bool:
    """Whether a folder holds the annotations."""
    return next(folder.glob("*_combined.png"), None) is not None


def read_kitti(folder: Path, images: Path | None) -> Iterator[Item]:
    """The annotated images.

    Args:
        folder: the annotations.
        images: a folder of images ``XXXXX.*``; or a text file that lists the images of the split
            in order, one per line, either as a path relative to the text file's folder or as
            ``DRIVE FRAME l|r``, the form of the Eigen split's lists.

    Raises:
        GroundTruthError: the images are not given.
    """
    if images is None:
        raise GroundTruthError(
            f"{folder} holds KITTI annotations without images; give --images a folder of "
            "XXXXX.png, or the text file that lists the test split, in the folder of the raw data"
        )
    find_image: Callable[[str], Path]
    lists: tuple[Path, ...] = ()
    if images.is_dir():
        find_image = partial(image_named, images)
    else:
        find_image = partial(_listed, images, images.read_text(encoding="utf-8").splitlines())
        lists = (images,)
    for combined in sorted(folder.glob("*_combined.png")):
        number = combined.name.removesuffix("_combined.png")
        outline = folder / f"{number}_ground.png"
        load = partial(_load, combined, outline, number, find_image)
        yield Item(number, load, (combined, outline, *lists))


def _load(
    combined: Path, outline: Path, number: str, find_image: Callable[[str], Path]
) -> GroundTruth:
    ground, region = _mask(combined), _mask(outline)
    if ground.shape != region.shape:
        raise GroundTruthError(
            f"{combined.parent}: the masks of {number} have shapes {ground.shape} and "
            f"{region.shape}; both must have the same"
        )
    image = find_image(number)
    with Image.open(image) as opened:
        width, height = opened.size
    fx, fy = _FOCAL_SHARES[0] * width, _FOCAL_SHARES[1] * height
    return GroundTruth(
        image,
        (ground.shape[0], ground.shape[1]),
        Intrinsics(fx, fy, (width - 1) / 2, (height - 1) / 2),
        ground=LabelledMask(ground, np.ones_like(ground)),
        region=region,
    )


def _mask(path: Path) -> Mask:
    return np.asarray(Image.open(path).convert("L")) > 128


def _listed(path: Path, lines: list[str], number: str) -> Path:
    """The image of an annotation, from the list of the split."""
    if not number.isdigit() or int(number) >= len(lines):
        raise GroundTruthError(
            f"{path}: lists {len(lines)} images, none for annotation {number}; give the full list "
            "of the test split"
        )
    words = lines[int(number)].split()
    if len(words) == 3 and words[2] in {"l", "r"}:
        drive, frame, side = words
        camera = "image_02" if side == "l" else "image_03"
        return image_named(path.parent / drive / camera / "data", f"{int(frame):010d}")
    return path.parent / lines[int(number)].strip()
