"""Scans of Matterport3D, with or without the training data published with the paper.

Raw: ``{scan}/{scan}/`` with ``matterport_color_images``, ``matterport_depth_images``,
``matterport_camera_poses`` and ``matterport_camera_intrinsics``. Each tripod position (``pos``) has
cameras at three heights (0 looks up, 1 ahead, 2 down) in six directions. Poses are camera to world
with x right, y down, z forward, as its documentation has it; the world's z points up.

Published, in a folder or a zip that stays packed: ``ground_seg``, ``hidden_depth`` and
``depth_masks``.
"""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import IntrinsicsError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.sequences.camera_files import checked_pose
from footprints_edge_models.sequences.npy_files import FirstChannel, NpyFile
from footprints_edge_models.sequences.sequence import (
    DepthPicture,
    InSpace,
    Sequence,
    SequenceError,
    SequenceFrame,
)

HEIGHTS = (1, 2)
"""The cameras that look ahead and down: those that the paper trains on."""
METRES_PER_UNIT = 0.00025
"""Unit of the depth pictures."""

_PICTURE = re.compile(r"(?P<pos>[0-9a-zA-Z]+)_i(?P<height>\d)_(?P<direction>\d)")


def is_scan(folder: Path) -> bool:
    """Whether a folder looks like a scan, the outer of its two folders or the inner one."""
    inner = folder / folder.name
    return any((each / "matterport_color_images").is_dir() for each in (folder, inner))


def read_matterport(
    raw: Path, scan: str, published: Path | None = None, heights: tuple[int, ...] = HEIGHTS
) -> Sequence:
    """Read a scan, for making labels.

    Args:
        raw: folder of the scans.
        scan: such as ``2azQ1b91cZZ``.
        published: folder or zip of the published training data, for its ground segmentation.
        heights: the cameras of the tripod to use.

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
            cameras[rig] = intrinsics_of(folder, pos, height)
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
                DepthPicture(depth_path(folder, pos, height, direction), METRES_PER_UNIT),
                FirstChannel(ground) if ground is not None and ground.exists() else None,
            )
        )
    if not frames:
        raise SequenceError(f"{pictures}: no pictures named POS_iHEIGHT_DIRECTION.jpg here")
    return Sequence(scan, tuple(frames), InSpace(), least_hits=0, up=(0.0, 0.0, 1.0))


def depth_path(folder: Path, pos: str, height: int, direction: int) -> Path:
    """Where the depth picture of a camera is."""
    return folder / "matterport_depth_images" / f"{pos}_d{height}_{direction}.png"


def _pose(folder: Path, pos: str, height: int, direction: int) -> NDArray[np.float64]:
    path = folder / "matterport_camera_poses" / f"{pos}_pose_{height}_{direction}.txt"
    try:
        return checked_pose(np.loadtxt(path), str(path))
    except (OSError, ValueError) as error:
        raise SequenceError(f"{path}: no readable pose ({error})") from error


def intrinsics_of(folder: Path, pos: str, height: int) -> Intrinsics:
    """The camera at one of the three heights of a tripod position.

    Raises:
        SequenceError: its file cannot be read.
    """
    path = folder / "matterport_camera_intrinsics" / f"{pos}_intrinsics_{height}.txt"
    try:
        _width, _height, fx, fy, cx, cy = np.loadtxt(path).ravel()[:6].tolist()
        return Intrinsics(fx, fy, cx, cy)
    except (OSError, ValueError, IntrinsicsError) as error:
        raise SequenceError(f"{path}: no readable 'w h fx fy cx cy …' ({error})") from error
