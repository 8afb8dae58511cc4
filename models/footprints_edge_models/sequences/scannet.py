"""ScanNet scans, exported by ScanNet's own reader.

``color/N.jpg``, ``depth/N.png`` (uint16 millimetres, seen from the colour camera), ``pose/N.txt``
(4x4, camera to world) and ``intrinsic/intrinsic_color.txt`` (4x4). Frames are numbered at 30 a
second; the world's z axis points up. Poses of frames whose tracking was lost hold no finite
numbers.
"""

import logging
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.sequences.camera_files import checked_intrinsics, checked_pose
from footprints_edge_models.sequences.moving_cameras import HAND_HELD, spread_in_time
from footprints_edge_models.sequences.sequence import (
    DepthPicture,
    Sequence,
    SequenceError,
    SequenceFrame,
)

logger = logging.getLogger(__name__)

FRAMES_PER_S = 30


def is_scannet(folder: Path) -> bool:
    """Whether a folder looks like an exported scan."""
    return (folder / "color").is_dir() and (folder / "pose").is_dir()


def read_scannet(folder: Path) -> Sequence:
    """The scan in a folder; frames that were not tracked are left out.

    Raises:
        SequenceError: a file is missing or odd, or no frame was tracked.
    """
    path = folder / "intrinsic" / "intrinsic_color.txt"
    camera = checked_intrinsics(_matrix(path)[:3, :3], str(path))
    images = {
        int(path.stem): path
        for path in (folder / "color").iterdir()
        if path.stem.isdecimal() and path.suffix in {".jpg", ".png"}
    }
    numbers = sorted(images)
    frames: list[SequenceFrame] = []
    kept = spread_in_time([number / FRAMES_PER_S for number in numbers])
    for number in (numbers[index] for index in kept):
        place = folder / "pose" / f"{number}.txt"
        pose, depth = _matrix(place), folder / "depth" / f"{number}.png"
        if not np.isfinite(pose).all():
            continue
        if not depth.is_file():
            raise SequenceError(f"{depth}: missing; export the depth pictures, too")
        frames.append(
            SequenceFrame(
                str(number),
                len(frames),
                images[number],
                camera,
                checked_pose(pose, str(place)),
                DepthPicture(depth),
            )
        )
    if not frames:
        raise SequenceError(f"{folder / 'color'}: no picture N.jpg whose pose is finite")
    if len(frames) < len(kept):
        logger.info("%s: %d frames without tracking left out", folder, len(kept) - len(frames))
    return Sequence(folder.resolve().name, tuple(frames), HAND_HELD, up=(0.0, 0.0, 1.0))


def _matrix(path: Path) -> NDArray[np.float64]:
    try:
        matrix = np.loadtxt(path)
    except (OSError, ValueError) as error:
        raise SequenceError(f"{path}: no readable 4x4 matrix ({error})") from error
    if matrix.shape != (4, 4):
        raise SequenceError(f"{path}: a 4x4 matrix is needed, not {matrix.shape}")
    return matrix
