"""Matterport3D, and the training data that was published with the paper for it.

Raw: ``{scan}/{scan}/`` with ``matterport_color_images``, ``matterport_depth_images``,
``matterport_camera_poses`` and ``matterport_camera_intrinsics``. Each tripod position (``pos``) has
cameras at three heights (0 looks up, 1 ahead, 2 down) in six directions. Poses are camera to world
with x right, y down, z forward, as its documentation has it; the world's z points up.

Published, in a folder or a zip that stays packed: ``ground_seg``, ``hidden_depth`` and
``depth_masks``.
"""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import IntrinsicsError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import decode
from footprints_edge_models.sample import Sample
from footprints_edge_models.sequences.camera_files import checked_pose
from footprints_edge_models.sequences.npy_files import FirstChannel, NpyFile
from footprints_edge_models.sequences.sequence import (
    DepthPicture,
    InSpace,
    Sequence,
    SequenceError,
    SequenceFrame,
)
from footprints_edge_models.video_labels.training_targets import label_sample

HEIGHTS = (1, 2)
"""The cameras that look ahead and down: those that the paper trains on."""
METRES_PER_UNIT = 0.00025
"""Of the depth pictures."""
NO_HIDDEN_DEPTH_M = 0.1
"""What the published hidden depths hold where there is none."""
FARTHEST_HIDDEN_M = 10.0
"""Published hidden depths from here on do not count."""

_PICTURE = re.compile(r"(?P<pos>[0-9a-zA-Z]+)_i(?P<height>\d)_(?P<direction>\d)")


def is_scan(folder: Path) -> bool:
    """Whether a folder looks like a scan, the outer of its two folders or the inner one."""
    inner = folder / folder.name
    return any((each / "matterport_color_images").is_dir() for each in (folder, inner))


def read_matterport(
    raw: Path, scan: str, published: Path | None = None, heights: tuple[int, ...] = HEIGHTS
) -> Sequence:
    """A scan, for making labels.

    Args:
        raw: folder of the scans.
        scan: such as ``2azQ1b91cZZ``.
        published: folder or zip of the published training data, for its ground segmentation.
        heights: which cameras of the tripod count.

    Raises:
        SequenceError: there is no such scan, or a file of it is missing or not as documented.
    """
    folder = raw / scan / scan
    pictures = folder / "matterport_color_images"
    if not pictures.is_dir():
        raise SequenceError(f"{pictures}: no such folder; unpack the scan's color images there")
    frames: list[SequenceFrame] = []
    cameras: dict[str, Intrinsics] = {}
    for image in sorted(pictures.glob("*.jpg")):
        match = _PICTURE.fullmatch(image.stem)
        if match is None or int(match["height"]) not in heights:
            continue
        pos, height, direction = match["pos"], int(match["height"]), int(match["direction"])
        rig = f"{pos}_{height}"
        if rig not in cameras:
            cameras[rig] = _intrinsics(folder, pos, height)
        ground = None
        if published is not None:
            ground = NpyFile(published, f"ground_seg/{scan}/data/{rig}_{direction}.npy")
        frames.append(
            SequenceFrame(
                f"{rig}_{direction}",
                len(frames),
                image,
                cameras[rig],
                _pose(folder, pos, height, direction),
                DepthPicture(_depth_path(folder, pos, height, direction), METRES_PER_UNIT),
                FirstChannel(ground) if ground is not None and ground.exists() else None,
            )
        )
    if not frames:
        raise SequenceError(f"{pictures}: no pictures named POS_iHEIGHT_DIRECTION.jpg here")
    return Sequence(scan, tuple(frames), InSpace(), least_hits=0, up=(0.0, 0.0, 1.0))


def read_matterport_training(raw: Path, published: Path, split: Iterable[str]) -> Iterator[Sample]:
    """The published labels as training samples.

    Args:
        raw: folder of the scans, for pictures, depth and intrinsics.
        published: folder or zip of the published training data.
        split: lines ``scan pos height direction``, as the published splits have them.

    Raises:
        SequenceError: a line, a picture or a label is not as published.
    """
    for line in filter(None, map(str.strip, split)):
        scan, pos, height, direction = _split_line(line)
        folder = raw / scan / scan
        name = f"{scan}/data/{pos}_{height}_{direction}.npy"
        hidden_m = np.squeeze(NpyFile(published, f"hidden_depth/{name}").read())
        told = (hidden_m > NO_HIDDEN_DEPTH_M) & (hidden_m < FARTHEST_HIDDEN_M)
        mask = NpyFile(published, f"depth_masks/{name}")
        image = folder / "matterport_color_images" / f"{pos}_i{height}_{direction}.jpg"
        depth = DepthPicture(_depth_path(folder, pos, height, direction), METRES_PER_UNIT)
        yield label_sample(
            f"{scan}/{pos}_{height}_{direction}",
            decode(image).rgb,
            _intrinsics(folder, pos, height),
            ground_probability=FirstChannel(NpyFile(published, f"ground_seg/{name}")).read(),
            ground_depth_m=np.where(told, hidden_m, 0),
            visible_depth_m=depth.read(),
            untraversable=np.squeeze(mask.read()) > 0 if mask.exists() else None,
        )


def _split_line(line: str) -> tuple[str, str, int, int]:
    try:
        scan, pos, height, direction = line.split()
        return scan, pos, int(height), int(direction)
    except ValueError as error:
        raise SequenceError(
            f"the line {line!r} is not 'scan pos height direction', such as "
            "'2azQ1b91cZZ fe0f8990834148809dc84feffa5797eb 1 1'"
        ) from error


def _depth_path(folder: Path, pos: str, height: int, direction: int) -> Path:
    return folder / "matterport_depth_images" / f"{pos}_d{height}_{direction}.png"


def _pose(folder: Path, pos: str, height: int, direction: int) -> NDArray[np.float64]:
    path = folder / "matterport_camera_poses" / f"{pos}_pose_{height}_{direction}.txt"
    try:
        return checked_pose(np.loadtxt(path), str(path))
    except (OSError, ValueError) as error:
        raise SequenceError(f"{path}: no readable pose ({error})") from error


def _intrinsics(folder: Path, pos: str, height: int) -> Intrinsics:
    path = folder / "matterport_camera_intrinsics" / f"{pos}_intrinsics_{height}.txt"
    try:
        _width, _height, fx, fy, cx, cy = np.loadtxt(path).ravel()[:6].tolist()
        return Intrinsics(fx, fy, cx, cy)
    except (OSError, ValueError, IntrinsicsError) as error:
        raise SequenceError(f"{path}: no readable 'w h fx fy cx cy …' ({error})") from error
