"""The published ground truth of Matterport's test images (paper, section "Indoor evaluation").

``{scan}_{pos}_{height}_{direction}_groundtruth.npy`` is the depth of the ground, rendered from the
annotated mesh with everything else removed; ``…_freespace.npy`` the region of evaluation, the
convex hull of the true visible ground. Pictures, cameras and measured depths are the raw data's.
"""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image

from footprints_edge.foundation.types import Floats, Size
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_bench.ground_truth.base import (
    GroundTruth,
    GroundTruthError,
    Item,
    LabelledMask,
)

_ENDING = "_groundtruth.npy"
_METRES_PER_UNIT = 0.00025
"""Of the raw depth pictures."""
_SEEN_M = 0.1
"""Ground is seen where the measured depth is that of the ground, within this."""


def is_matterport_folder(folder: Path) -> bool:
    """Whether a folder holds the ground truth files."""
    return next(folder.glob(f"*{_ENDING}"), None) is not None


def read_matterport(folder: Path, images: Path | None) -> Iterator[Item]:
    """The test images.

    Args:
        folder: of the ground truth files.
        images: root of the raw data, with ``{scan}/{scan}/matterport_color_images``.

    Raises:
        GroundTruthError: the raw data is not given.
    """
    if images is None or not images.is_dir():
        raise GroundTruthError(
            f"{folder} holds Matterport ground truth without pictures; give --images the folder of the "
            "scans' raw data"
        )
    for path in sorted(folder.glob(f"*{_ENDING}")):
        yield Item(path.name.removesuffix(_ENDING), partial(_load, path, images))


def _load(path: Path, images: Path) -> GroundTruth:
    stem = path.name.removesuffix(_ENDING)
    try:
        scan, pos, height, direction = stem.rsplit("_", 3)
    except ValueError:
        raise GroundTruthError(
            f"{path}: the name is not SCAN_POS_HEIGHT_DIRECTION{_ENDING}"
        ) from None
    raw = images / scan / scan
    ground_depth_m = _map(path)
    size = (ground_depth_m.shape[0], ground_depth_m.shape[1])
    ground = ground_depth_m > 0.1  # the published threshold
    region = _map(path.with_name(f"{stem}_freespace.npy")) > 0.5
    if region.shape != size:
        raise GroundTruthError(f"{path}: ground is {size}, the region of evaluation {region.shape}")
    everywhere = np.ones(size, bool)
    visible, visible_depth_m = None, None
    measured = raw / "matterport_depth_images" / f"{pos}_d{height}_{direction}.png"
    if measured.is_file():
        visible_depth_m = _depth_m(measured, size)
        seen = ground & (np.abs(visible_depth_m - ground_depth_m) < _SEEN_M)
        visible = LabelledMask(seen, visible_depth_m > 0)
    return GroundTruth(
        raw / "matterport_color_images" / f"{pos}_i{height}_{direction}.jpg",
        size,
        _intrinsics(raw / "matterport_camera_intrinsics" / f"{pos}_intrinsics_{height}.txt"),
        visible,
        LabelledMask(ground, everywhere),
        visible_depth_m,
        np.where(ground, ground_depth_m, 0).astype(np.float32),
        region,
    )


def _map(path: Path) -> Floats:
    values: Floats = np.squeeze(np.load(path)).astype(np.float32)
    if values.ndim != 2:
        raise GroundTruthError(f"{path}: a map (H, W) is needed, not shape {values.shape}")
    return values


def _depth_m(path: Path, size: Size) -> Floats:
    units = Image.fromarray(np.asarray(Image.open(path)).astype(np.float32))
    nearest = units.resize((size[1], size[0]), Image.Resampling.NEAREST)
    depth_m: Floats = np.asarray(nearest) * np.float32(_METRES_PER_UNIT)
    return depth_m


def _intrinsics(path: Path) -> Intrinsics:
    """Of a file with ``width height fx fy cx cy`` and distortion."""
    numbers = [float(word) for word in path.read_text(encoding="utf-8").split()]
    if len(numbers) < 6:
        raise GroundTruthError(
            f"{path}: width height fx fy cx cy are needed, not {len(numbers)} numbers"
        )
    fx, fy, cx, cy = numbers[2:6]
    return Intrinsics(fx, fy, cx, cy)
