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
ENCLOSED_M2 = 0.8
"""Smaller patches of ground that a thing encloses are inside of it."""


def outlines_of(surfaces: Sequence[Surface], category: str) -> list[NDArray[np.float64]]:
    """Convex outlines of the ground that a model takes.

    The ground below everything that reaches below STANDS_BELOW_M is taken, and small patches that
    it encloses; of vehicles, the ground below the whole body.
    """
    triangles = np.concatenate([surface.points[surface.triangles] for surface in surfaces])
    if category in VEHICLES:
        return [vehicle_outline(triangles)]
    return outlines_below(triangles)


def vehicle_outline(triangles: NDArray[np.floating]) -> NDArray[np.float64]:
    """The outline (K, 2) of the body of a vehicle, triangles (T, 3, 3)."""
    low = triangles.reshape(-1, 3)
    body = low[low[:, 2] < _BODY_M, :2].astype(np.float32)
    return np.asarray(cv2.convexHull(body)[:, 0], np.float64)


def outlines_below(
    triangles: NDArray[np.floating], cell_m: float = _CELL_M
) -> list[NDArray[np.float64]]:
    """Convex outlines of the ground below triangles (T, 3, 3), where they are low.

    That is below STANDS_BELOW_M. Small patches that they enclose are taken, too.
    """
    low = triangles[triangles[..., 2].min(axis=1) < STANDS_BELOW_M]
    if not len(low):
        return []
    points = low[..., :2].reshape(-1, 2)
    corner = points.min(axis=0) - 2 * cell_m
    columns, rows = (np.ceil(np.ptp(points, axis=0) / cell_m).astype(int) + 5).tolist()
    grid = np.zeros((rows, columns), np.uint8)
    draw_outlines(grid, _clipped(low), corner, cell_m)
    _fill_enclosed(grid, cell_m)
    return outlines_of_cells(grid, corner, cell_m)


def draw_outlines(
    grid: NDArray[np.uint8],
    outlines: Sequence[NDArray[np.floating]],
    corner: NDArray[np.floating],
    cell_m: float,
) -> None:
    """Sets the cells (H, W) of a plan that polygons (K, 2) touch.

    A row runs along x; the middle of the first cell is at ``corner``.
    """
    for outline in outlines:
        pixels = np.round((outline - corner) / cell_m * 16).astype(np.int32)
        cv2.fillPoly(grid, [pixels], 1, shift=4)


def outlines_of_cells(
    grid: NDArray[np.uint8], corner: NDArray[np.floating], cell_m: float
) -> list[NDArray[np.float64]]:
    """Rectangles (4, 2) that cover the set cells of a plan; see :func:`draw_outlines`."""
    return [
        _rectangle(
            corner[0] + (start - 0.5) * cell_m,
            corner[1] + (top - 0.5) * cell_m,
            corner[0] + (end - 0.5) * cell_m,
            corner[1] + (bottom - 0.5) * cell_m,
        )
        for start, end, top, bottom in _rectangles(grid)
    ]


def _clipped(triangles: NDArray[np.floating]) -> list[NDArray[np.float64]]:
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


def _fill_enclosed(grid: NDArray[np.uint8], cell_m: float) -> None:
    """Takes free patches that touch no border and are small."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(1 - grid, connectivity=4)
    inside = stats[:, cv2.CC_STAT_AREA] * cell_m**2 < ENCLOSED_M2
    inside[np.concatenate([labels[[0, -1]].ravel(), labels[:, [0, -1]].ravel()])] = False
    inside[0] = False  # what is taken
    grid[inside[labels]] = 1


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
