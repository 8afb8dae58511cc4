"""Measured depth that other frames of the clip refute.

A time-of-flight sensor reports surfaces where there are none: points a metre above an open floor,
where the phase wraps. They are few, but the nearest thing on a bearing is just that. A frame from
another place looks through them.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Mask

if TYPE_CHECKING:
    from footprints_edge_models.mapping.floor_map import DepthFrame

_SAME, _THROUGH = 0.06, 0.12
"""Another frame sees a point if its depth there is within this share of the point's, and sees
through it if its depth is more than that share longer."""

_LEAST_FRAMES = 3
_NEAREST_M = 0.3


def seen_through(frame: "DepthFrame", others: Iterable["DepthFrame"]) -> Mask:
    """Where the depth of a frame is refuted: three other frames look through the point.

    They must be more than twice as many as those that see it there. What moves is refuted as well.

    Args:
        frame: the frame.
        others: frames from other places.

    Returns:
        bool (H, W).
    """
    pixels = np.flatnonzero(frame.depth_m > 0)
    points = frame.points().reshape(-1, 3)[pixels]
    seen, through = np.zeros((2, len(pixels)), np.int32)
    for other in others:
        depth_m, expected_m = _looked_up(other, points)
        there = depth_m > 0
        seen += there & (np.abs(depth_m - expected_m) < _SAME * expected_m)
        through += there & (depth_m > (1 + _THROUGH) * expected_m)
    refuted = np.zeros(frame.depth_m.shape, bool)
    refuted.flat[pixels[(through >= _LEAST_FRAMES) & (through > 2 * seen)]] = True
    return refuted


def _looked_up(
    frame: "DepthFrame", points: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The frame's depth towards each point (N, 3), 0 where unknown, and the point's own depth."""
    rotation, translation = frame.camera_to_world[:3, :3], frame.camera_to_world[:3, 3]
    x, y, z = ((points - translation) @ rotation).T
    camera, (height, width) = frame.intrinsics, frame.depth_m.shape
    ahead = z > _NEAREST_M
    stretch = 1 / np.where(ahead, z, 1)
    column = np.rint(camera.fx * x * stretch + camera.cx).astype(int)
    row = np.rint(camera.fy * y * stretch + camera.cy).astype(int)
    inside = ahead & (column >= 0) & (column < width) & (row >= 0) & (row < height)
    depth_m = np.zeros(len(points))
    depth_m[inside] = frame.depth_m[row[inside], column[inside]]
    return depth_m, z
