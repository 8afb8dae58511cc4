"""Filters of light that stay on one surface."""

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.scenes.rendering.raycast import Floats32
from footprints_edge_models.scenes.rendering.shading.surfaces import Surface

Keys = NDArray[np.int32]
"""Which surface each pixel shows, (H, W)."""

_AROUND = tuple((y, x) for y in range(-1, 3) for x in range(-1, 3))


def surface_keys(surface: Surface) -> NDArray[np.int32]:
    """A number for each point (N,), the same on surfaces that look the same way."""
    quantised = np.round(surface.normals * 2).astype(np.int32) + 2
    return np.asarray(
        surface.part * 125 + quantised[0] * 25 + quantised[1] * 5 + quantised[2], np.int32
    )


def with_neighbours(values: Floats32, keys: Keys, step: int) -> Floats32:
    """Sums (C, H, W) with those of the eight pixels ``step`` away that are on the same surface."""
    total = values.copy()
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        y, x = dy * step, dx * step
        here = (slice(None, -y or None), slice(max(0, -x), -x if x > 0 else None))
        there = (slice(y, None), slice(max(0, x), x if x < 0 else None))
        same = (keys[here] == keys[there]).astype(np.float32)
        for old, new in zip(values, total, strict=True):
            new[here] += old[there] * same
            new[there] += old[here] * same
    return total


def means(sums: Floats32) -> Floats32:
    """Sums (C, H, W), weight last, as means (C - 1, H, W); slivers take what is around them."""
    lonely = sums[-1] < 0.5
    if lonely.any():
        for plane in sums:
            plane[lonely] = cv2.blur(plane, (9, 9))[lonely]
    return np.asarray(sums[:-1] / np.maximum(sums[-1], 1e-6))


def refined(values: Floats32, coarse: Keys, fine: Keys) -> Floats32:
    """Values of every second pixel along each side, (C, h, w), between these; (C, H, W).

    Each pixel takes the mean of the nearest ones on its own surface.

    Args:
        values: (C, h, w).
        coarse: (h, w), the surfaces of these pixels.
        fine: (H, W), those of all.
    """
    values = np.pad(values, ((0, 0), (0, 1), (0, 1)), mode="edge")
    coarse = np.pad(coarse, ((0, 1), (0, 1)), mode="edge")
    found = np.empty((len(values), *fine.shape), np.float32)
    for dy, dx in ((0, 0), (0, 1), (1, 0), (1, 1)):
        keys = fine[dy::2, dx::2]
        height, width = keys.shape
        total = np.zeros((len(values), height, width), np.float32)
        weight = np.zeros((height, width), np.float32)
        for y in range(dy + 1):
            for x in range(dx + 1):
                near = (slice(y, y + height), slice(x, x + width))
                same = (coarse[near] == keys).astype(np.float32)
                total += values[:, near[0], near[1]] * same
                weight += same
        found[:, dy::2, dx::2] = total / np.maximum(weight, 1)
        alone = np.flatnonzero(weight == 0)
        if len(alone):
            row, column = np.divmod(alone, width)
            found[:, dy::2, dx::2][:, row, column] = _of_wider(
                values, coarse, row, column, keys[row, column]
            )
    return found


def _of_wider(
    values: Floats32,
    coarse: Keys,
    row: NDArray[np.int64],
    column: NDArray[np.int64],
    keys: NDArray[np.int32],
) -> Floats32:
    """Means (C, M) over the sixteen pixels around on surfaces ``keys``; over all without any."""
    total = np.zeros((len(values), len(row)), np.float32)
    anything, weight = total.copy(), np.zeros(len(row), np.float32)
    for y, x in _AROUND:
        at_y, at_x = (
            np.clip(row + y, 0, len(coarse) - 1),
            np.clip(column + x, 0, coarse.shape[1] - 1),
        )
        near, same = values[:, at_y, at_x], coarse[at_y, at_x] == keys
        total += near * same
        weight += same
        anything += near
    return np.asarray(
        np.where(weight > 0, total / np.maximum(weight, 1), anything / np.float32(len(_AROUND)))
    )
