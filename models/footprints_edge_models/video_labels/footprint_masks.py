"""Footprint masks: pixels whose ground an object stands on (paper, section "Depth masking").

Every point that is not ground is projected along the ground plane's normal onto the plane. Where it
lands beneath the surface that the camera sees there, somebody would walk into it.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics, backproject, rays
from footprints_edge_models.mapping.planes import fit_plane

GROUND_PROBABILITY = 0.75
"""Above this a pixel is ground to fit planes to and to warp; below 0.5 it is not."""
NOT_GROUND_PROBABILITY = 0.5
"""Below this a pixel is not ground; between the two it is undecided."""
LEAST_GROUND_PX = 100
"""Fewer ground pixels carry no plane: then the mask is empty."""
FARTHEST_M = 30.0
NEAR_SHARE = 0.1
"""A splat counts where it meets the plane within this share of the depth seen there: at the foot of
its own object."""
LARGEST_SHARE = 0.01
"""Connected regions larger than this share of the picture are walls and errors, not footprints."""

_CELL_M = 0.0125
_SPLAT, _BACKWARD = 15, 6
"""A point fills the cells from 0.1 m before it to 0.075 m behind it along both axes of the plane:
what the published steps of 0.025 m from -0.1 m to 0.1 m, the last excluded, reach."""


def footprint_pixels(
    depth_m: NDArray[np.float32],
    ground_probability: NDArray[np.float32],
    intrinsics: Intrinsics,
    seed: int = 0,
    *,
    as_published: bool = False,
) -> NDArray[np.bool_]:
    """The footprint mask of a frame, before large regions are dropped.

    Splats are kept as cells of the plane, each once. Far away, where a pixel covers many cells,
    the cells are projected into the picture; nearby, where a cell covers many pixels, the pixels
    look up theirs.

    Args:
        depth_m: float32 (H, W), metres along the optical axis, 0 where unknown.
        ground_probability: float32 (H, W), probability of visible ground.
        intrinsics: the camera, in pixels of (H, W).
        seed: seed of the plane's RANSAC.
        as_published: truncate projected coordinates, as the paper's code does, instead of rounding
            them.

    Returns:
        bool (H, W); all False where fewer than ``LEAST_GROUND_PX`` pixels are ground.
    """
    height, width = depth_m.shape
    result = np.zeros((height, width), bool)
    points = backproject(depth_m, intrinsics)
    seen = depth_m > 0
    is_ground = (ground_probability > GROUND_PROBABILITY) & seen
    if is_ground.sum() < LEAST_GROUND_PX:
        return result
    plane = fit_plane(points[is_ground], np.random.default_rng(seed))
    plane = plane and plane.facing(np.array([0.0, -1.0, 0.0]))  # upwards: axes that do not flip
    standing = points[(ground_probability <= GROUND_PROBABILITY) & seen & (depth_m < FARTHEST_M)]
    if plane is None or not len(standing):
        return result

    axes = np.stack(plane.axes())
    cells = np.floor(standing @ axes.T / _CELL_M).astype(np.int64)
    origin = cells.min(axis=0) - _SPLAT
    occupied = np.zeros(cells.max(axis=0) + _SPLAT - origin + 1, np.uint8)
    occupied[tuple((cells - origin).T)] = 1
    kernel = np.ones((_SPLAT, _SPLAT), np.uint8)
    occupied = cv2.dilate(occupied, kernel, anchor=(_BACKWARD, _BACKWARD))

    # A pixel reaches from its index to the next as published, half a pixel around it otherwise.
    middle = 0.5 if as_published else 0.0
    feet = (np.argwhere(occupied) + origin + 0.5) * _CELL_M @ axes + plane.offset_m * plane.normal
    feet = feet[(feet[:, 2] > 0.1) & (feet[:, 2] < FARTHEST_M)]
    columns, rows = (
        np.floor(focal * feet[:, axis] / feet[:, 2] + centre + 0.5 - middle).astype(np.int64)
        for axis, focal, centre in (
            (0, intrinsics.fx, intrinsics.cx),
            (1, intrinsics.fy, intrinsics.cy),
        )
    )
    inside = (rows >= 0) & (rows < height) & (columns >= 0) & (columns < width)
    rows, columns, foot_m = rows[inside], columns[inside], feet[inside, 2]
    beneath = np.abs(foot_m - depth_m[rows, columns]) < NEAR_SHARE * depth_m[rows, columns]
    result[rows[beneath], columns[beneath]] = True

    directions = rays(intrinsics, (height, width)) + np.array(
        [middle / intrinsics.fx, middle / intrinsics.fy, 0], np.float32
    )
    floor_m = plane.depth_m(directions)
    near = (floor_m > 0.1) & (floor_m < FARTHEST_M)
    near &= np.abs(floor_m - depth_m) < NEAR_SHARE * depth_m
    met = np.floor((directions[near] * floor_m[near, None]) @ axes.T / _CELL_M) - origin
    inside = ((met >= 0) & (met < occupied.shape)).all(axis=1)
    hit = np.zeros(len(met), bool)
    hit[inside] = occupied[tuple(met[inside].astype(np.int64).T)] > 0
    result[near] |= hit
    return result & (ground_probability < 0.5) & seen


def drop_large_regions(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """A mask (H, W) without its connected regions of more than ``LARGEST_SHARE`` of the picture."""
    _, regions, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    small = stats[:, cv2.CC_STAT_AREA] < LARGEST_SHARE * mask.size
    small[0] = False  # the background
    kept: NDArray[np.bool_] = small[regions]
    return kept
