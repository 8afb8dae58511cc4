"""The published ground truth of Matterport's test images (paper, section "Indoor evaluation").

``{scan}_{pos}_{height}_{direction}_groundtruth.npy`` is the depth of the ground, rendered from the
annotated mesh with everything else removed. ``…_freespace.npy`` is the region in which footprints
are scored, the convex hull of the visible ground. Images, cameras and measured depths come from the
raw data.
"""

from collections.abc import Iterator
from dataclasses import dataclass
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
"""Unit of the raw depth images."""
_VISIBLE_WITHIN_M = 0.1
"""Ground counts as visible where the measured depth is within this distance of the ground's."""


def is_matterport_folder(folder: Path) -> bool:
    """Whether a folder holds the ground-truth files."""
    return next(folder.glob(f"*{_ENDING}"), None) is not None


def read_matterport(folder: Path, images: Path | None) -> Iterator[Item]:
    """The test images.

    Args:
        folder: the ground-truth files.
        images: root of the raw data, with ``{scan}/{scan}/matterport_color_images``.

    Raises:
        GroundTruthError: the raw data is not given.
    """
    if images is None or not images.is_dir():
        raise GroundTruthError(
            f"{folder} holds Matterport ground truth without images; give --images the folder of "
            "the scans' raw data"
        )
    for path in sorted(folder.glob(f"*{_ENDING}")):
        yield Item(
            path.name.removesuffix(_ENDING), partial(_load, path, images), _sources(path, images)
        )


@dataclass(frozen=True)
class _Files:
    """The files of one test image."""

    ground_depth: Path
    region: Path
    image: Path
    measured_depth: Path
    camera: Path


def _sources(ground_depth: Path, images: Path) -> tuple[Path, ...]:
    """Every file that decides the ground truth."""
    try:
        files = _files(ground_depth, images)
    except GroundTruthError:  # loading this image will fail and say why; others still count
        return (ground_depth,)
    return (files.ground_depth, files.region, files.measured_depth, files.camera)


def _files(ground_depth: Path, images: Path) -> _Files:
    stem = ground_depth.name.removesuffix(_ENDING)
    try:
        scan, pos, height, direction = stem.rsplit("_", 3)
    except ValueError:
        raise GroundTruthError(
            f"{ground_depth}: the name is not SCAN_POS_HEIGHT_DIRECTION{_ENDING}; keep the "
            "published names"
        ) from None
    raw = images / scan / scan
    return _Files(
        ground_depth,
        ground_depth.with_name(f"{stem}_freespace.npy"),
        raw / "matterport_color_images" / f"{pos}_i{height}_{direction}.jpg",
        raw / "matterport_depth_images" / f"{pos}_d{height}_{direction}.png",
        raw / "matterport_camera_intrinsics" / f"{pos}_intrinsics_{height}.txt",
    )


def _load(ground_depth: Path, images: Path) -> GroundTruth:
    files = _files(ground_depth, images)
    ground_depth_m = _map(files.ground_depth)
    size = (ground_depth_m.shape[0], ground_depth_m.shape[1])
    ground = ground_depth_m > 0.1  # the published threshold
    region = _map(files.region) > 0.5
    if region.shape != size:
        raise GroundTruthError(
            f"{files.ground_depth}: the ground has shape {size}, the region in {files.region.name} "
            f"{region.shape}; both must have the same"
        )
    visible, visible_depth_m = None, None
    if files.measured_depth.is_file():
        visible_depth_m = _depth_m(files.measured_depth, size)
        near = np.abs(visible_depth_m - ground_depth_m) < _VISIBLE_WITHIN_M
        visible = LabelledMask(ground & near, visible_depth_m > 0)
    return GroundTruth(
        files.image,
        size,
        _intrinsics(files.camera),
        visible,
        LabelledMask(ground, np.ones(size, bool)),
        visible_depth_m,
        np.where(ground, ground_depth_m, 0).astype(np.float32),
        region,
    )


def _map(path: Path) -> Floats:
    values: Floats = np.squeeze(np.load(path)).astype(np.float32)
    if values.ndim != 2:
        raise GroundTruthError(f"{path}: the array has shape {values.shape}; give a map (H, W)")
    return values


def _depth_m(path: Path, size: Size) -> Floats:
    units = Image.fromarray(np.asarray(Image.open(path)).astype(np.float32))
    nearest = units.resize((size[1], size[0]), Image.Resampling.NEAREST)
    depth_m: Floats = np.asarray(nearest) * np.float32(_METRES_PER_UNIT)
    return depth_m


def _intrinsics(path: Path) -> Intrinsics:
    """The camera in a file of ``width height fx fy cx cy`` and distortion coefficients."""
    numbers = [float(word) for word in path.read_text(encoding="utf-8").split()]
    if len(numbers) < 6:
        raise GroundTruthError(
            f"{path}: holds {len(numbers)} numbers; it needs width height fx fy cx cy"
        )
    fx, fy, cx, cy = numbers[2:6]
    return Intrinsics(fx, fy, cx, cy)
