"""The ground that a model takes, as convex outlines."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.asset_files.asset import Surface

STANDS_BELOW_M = 0.35
"""A part that reaches lower than this has a footprint. One that begins higher, such as a table top,
has none (as in the floor maps of RGB-D clips, ``mapping.floor_map.LOW_M``)."""

VEHICLES = frozenset({"car", "van", "truck", "bus", "Vehicles"})
"""Categories of vehicles."""

_BODY_M = 0.9
"""The body of a vehicle, below this height, covers the ground below it."""
_CELL_M = 0.02
_ENCLOSED_M2 = 0.8
"""Smaller patches of ground that a thing encloses are inside of it."""


def outlines_of(surfaces: Sequence[Surface], category: str) -> list[NDArray[np.float64]]:
    """Convex outlines of the ground that a model takes.

    The ground below everything that reaches below STANDS_BELOW_M is taken, and small patches that
    it encloses; of vehicles, the ground below the whole body.
    """
    triangles = np.concatenate([surface.points[surface.triangles] for surface in surfaces])
    if category in VEHICLES:
        low = triangles.reshape(-1, 3)
        body = low[low[:, 2] < _BODY_M, :2].astype(np.float32)
        return [cv2.convexHull(body)[:, 0].astype(np.float64)]
    low = triangles[triangles[..., 2].min(axis=1) < STANDS_BELOW_M]
    if not len(low):
        return []
    points = low[..., :2].reshape(-1, 2)
    corner = points.min(axis=0) - 2 * _CELL_M
    columns, rows = (np.ceil(np.ptp(points, axis=0) / _CELL_M).astype(int) + 5).tolist()
    grid = np.zeros((rows, columns), np.uint8)
    for polygon in _clipped(low):
        pixels = np.round((polygon - corner) / _CELL_M * 16).astype(np.int32)
        cv2.fillPoly(grid, [pixels], 1, shift=4)
    _fill_enclosed(grid)
    return [
        _rectangle(
            corner[0] + (start - 0.5) * _CELL_M,
            corner[1] + (top - 0.5) * _CELL_M,
            corner[0] + (end - 0.5) * _CELL_M,
            corner[1] + (bottom - 0.5) * _CELL_M,
        )
        for start, end, top, bottom in _rectangles(grid)
    ]


def _clipped(triangles: NDArray[np.float32]) -> list[NDArray[np.float64]]:
    """The parts of triangles below STANDS_BELOW_M, as polygons (K, 2) seen from above."""
    polygons = []
    heights = triangles[..., 2]
    whole = heights.max(axis=1) <= STANDS_BELOW_M
    polygons += list(triangles[whole][..., :2].astype(np.float64))
    for triangle in triangles[~whole].astype(np.float64):
        kept = []
        for here, there in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
            if here[2] <= STANDS_BELOW_M:
                kept.append(here[:2])
            if (here[2] <= STANDS_BELOW_M) != (there[2] <= STANDS_BELOW_M):
                share = (STANDS_BELOW_M - here[2]) / (there[2] - here[2])
                kept.append((here + share * (there - here))[:2])
        if len(kept) > 1:
            polygons.append(np.array(kept))
    return polygons


def _fill_enclosed(grid: NDArray[np.uint8]) -> None:
    """Takes free patches that touch no border and are small."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(1 - grid, connectivity=4)
    outside = set(np.unique(np.concatenate([labels[[0, -1]].ravel(), labels[:, [0, -1]].ravel()])))
    for label in range(1, count):
        area_m2 = stats[label, cv2.CC_STAT_AREA] * _CELL_M**2
        if label not in outside and area_m2 < _ENCLOSED_M2:
            grid[labels == label] = 1


def _rectangles(grid: NDArray[np.uint8]) -> list[tuple[int, int, int, int]]:
    """(start, end, top, bottom) of rectangles that cover the set cells: runs of rows, merged."""
    found: list[tuple[int, int, int, int]] = []
    open_runs: dict[tuple[int, int], int] = {}
    for row in range(len(grid) + 1):
        runs = set()
        if row < len(grid):
            edges = np.flatnonzero(np.diff(np.concatenate([[0], grid[row], [0]])))
            runs = {(int(a), int(b)) for a, b in edges.reshape(-1, 2)}
        ended = [run for run in open_runs if run not in runs]
        found += [(*run, open_runs.pop(run), row) for run in ended]
        for run in runs:
            open_runs.setdefault(run, row)
    return found


def _rectangle(x0: float, y0: float, x1: float, y1: float) -> NDArray[np.float64]:
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], np.float64)
