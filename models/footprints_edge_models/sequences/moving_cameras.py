"""What readers of hand-held RGB-D clips share: rates, neighbours, rotations, tables of numbers."""

import math
from collections.abc import Sequence as Many
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.sequences.camera_files import checked_pose
from footprints_edge_models.sequences.sequence import InTime, SequenceError

LEAST_GAP_S = 0.1
"""Frames nearer in time than this show the same: ten a second are kept."""
HAND_HELD = InTime(before=100, after=100, step=3)
"""Neighbours of the frames that are kept: ten seconds back and ahead, every third one."""
_ROUNDING_S = 0.01


def spread_in_time(times_s: Many[float]) -> list[int]:
    """Indices of frames at least ``LEAST_GAP_S`` apart, of ascending times in seconds."""
    kept: list[int] = []
    for index, time_s in enumerate(times_s):
        if not kept or time_s - times_s[kept[-1]] >= LEAST_GAP_S - _ROUNDING_S:
            kept.append(index)
    return kept


def pose_of_quaternion(
    position_m: Many[float], quaternion: Many[float], where: str
) -> NDArray[np.float64]:
    """The pose (4, 4) of a position and a rotation x, y, z, w.

    Raises:
        SequenceError: the rotation is none, or a number is not finite.
    """
    x, y, z, w = quaternion
    length = float(np.linalg.norm(quaternion))
    if not np.isfinite(length) or abs(length - 1) > 0.01:
        raise SequenceError(
            f"{where}: the quaternion {tuple(quaternion)} has length {length:g}; a rotation has 1"
        )
    x, y, z, w = (value / length for value in (x, y, z, w))
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = position_m
    return checked_pose(pose, where)


def quarter_turns(poses: Many[NDArray[np.float64]]) -> int:
    """Clockwise quarter turns, 0 to 3, that make most of a clip's pictures upright.

    Args:
        poses: camera to world, (4, 4); the world's y axis points up.
    """
    down = np.sum([pose[:3, :3].T @ [0, -1, 0] for pose in poses], axis=0)
    return round(math.atan2(down[0], down[1]) / (math.pi / 2)) % 4


def read_lines(path: Path) -> list[str]:
    """The lines of a text file without comments (``#``); blank lines stay.

    Raises:
        SequenceError: it cannot be read.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError) as error:
        raise SequenceError(f"{path}: not readable as text ({error})") from error
    return [line for line in lines if not line.startswith("#")]


def numbers_of(words: Many[str], where: str) -> list[float]:
    """Words as numbers.

    Raises:
        SequenceError: one is none.
    """
    try:
        return [float(word) for word in words]
    except ValueError as error:
        raise SequenceError(f"{where}: {' '.join(words)!r:.200} are not numbers") from error
