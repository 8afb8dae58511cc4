"""Sampling and grouping of points as in PointNet++ (Qi et al. 2017), section 3.

They depend on coordinates only, so one implementation serves every engine.
"""

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Floats

Indices = NDArray[np.int64]

_BLOCK = 256


def farthest_points(points: Floats, count: int) -> Indices:
    """Iterative farthest-point sampling, from the first point on.

    Args:
        points: float32 (n, 3).
        count: number of points to choose, at most n.

    Returns:
        int64 (count,), each the farthest from all chosen before it.
    """
    axes = np.ascontiguousarray(points.T)
    chosen = np.zeros(count, np.int64)
    nearest = np.full(axes.shape[1], np.inf, np.float32)
    offset, squared = np.empty_like(nearest), np.empty_like(nearest)
    for place in range(1, count):
        at = chosen[place - 1]
        squared.fill(0)
        for axis in axes:
            np.subtract(axis, axis[at], out=offset)
            np.multiply(offset, offset, out=offset)
            squared += offset
        np.minimum(nearest, squared, out=nearest)
        chosen[place] = nearest.argmax()
    return chosen


def ball_query(points: Floats, centres: Floats, radius: float, count: int) -> Indices:
    """The first points within a radius of each centre.

    Args:
        points: float32 (n, 3).
        centres: float32 (m, 3), each within the radius of some point, as samples of them are.
        radius: in the points' unit.
        count: points for each centre.

    Returns:
        int64 (m, count), in the order of the points; the first again where there are fewer.
    """
    found = np.zeros((len(centres), count), np.int64)
    for top in range(0, len(centres), _BLOCK):
        block = slice(top, top + _BLOCK)
        rows, columns = np.nonzero(_squared(centres[block], points) <= radius**2)
        starts = np.searchsorted(rows, np.arange(len(centres[block]) + 1))
        rank = np.arange(len(rows)) - starts[rows]
        found[block] = columns[np.minimum(starts[:-1], len(columns) - 1)][:, None]
        kept = rank < count
        found[block][rows[kept], rank[kept]] = columns[kept]
    return found


def three_nearest(points: Floats, targets: Floats) -> tuple[Indices, Floats]:
    """What features at targets are interpolated from, by inverse distance.

    Args:
        points: float32 (n, 3), n of 3 or more.
        targets: float32 (m, 3).

    Returns:
        int64 (m, 3) and float32 (m, 3), whose rows add up to 1.
    """
    squared = _squared(targets, points)
    nearest = np.argpartition(squared, 2, axis=1)[:, :3]
    weights = 1 / (np.take_along_axis(squared, nearest, 1) + 1e-8)
    weights /= weights.sum(1, keepdims=True)
    return nearest, weights.astype(np.float32)


def _squared(a: Floats, b: Floats) -> Floats:
    """Squared distances (m, n) of two sets of points."""
    squared: Floats = (a * a).sum(1)[:, None] + (b * b).sum(1) - 2 * a @ b.T
    return np.maximum(squared, 0, out=squared)
