"""Intrinsics and poses from files, checked before they are used."""

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import IntrinsicsError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.sequences.sequence import SequenceError

_MOST_SKEW = 0.01
"""Files round: rotations of published clips are orthonormal to some ten thousandths."""


def checked_intrinsics(values: object, where: str) -> Intrinsics:
    """A camera from its matrix, unchanged.

    Args:
        values: (3, 3): focal lengths and principal point, in pixels.
        where: its place, for messages.

    Raises:
        SequenceError: it has another shape, or numbers that no camera has.
    """
    try:
        matrix = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        matrix = np.zeros(0)
    if matrix.shape != (3, 3):
        raise SequenceError(f"{where}: intrinsics are a 3x3 matrix of numbers, not {values!r:.200}")
    (fx, _, cx), (_, fy, cy), _ = matrix.tolist()
    try:
        return Intrinsics(fx, fy, cx, cy)
    except IntrinsicsError as error:
        raise SequenceError(f"{where}: {error}") from error


def checked_pose(values: object, where: str) -> NDArray[np.float64]:
    """A rigid motion, from 12 or 16 numbers in row-major order.

    Args:
        values: (3, 4), (4, 4), or the same numbers in a row.
        where: its place, for messages.

    Returns:
        float64 (4, 4).

    Raises:
        SequenceError: it has another shape, is not finite, or is no rotation and translation.
    """
    try:
        numbers = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise SequenceError(f"{where}: a pose of numbers is needed ({error})") from error
    if numbers.size not in (12, 16):
        raise SequenceError(
            f"{where}: a pose is 3x4 or 4x4, camera to world, not {numbers.shape} numbers"
        )
    pose = np.eye(4)
    pose[:3] = numbers.reshape(-1, 4)[:3]
    if not np.isfinite(pose).all():
        raise SequenceError(
            f"{where}: the pose holds numbers that are not finite; leave the frame out of the "
            "sequence where tracking was lost"
        )
    rotation = pose[:3, :3]
    skew = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if skew > _MOST_SKEW or np.linalg.det(rotation) < 0:
        raise SequenceError(
            f"{where}: the pose is not rigid (its first three columns differ from a rotation by "
            f"{skew:.2g}); camera axes are x right, y down, z forward, without scale"
        )
    return pose
