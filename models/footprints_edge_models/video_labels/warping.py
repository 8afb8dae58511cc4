"""Warps the ground of other frames into this one (paper, eq. 1 and 2).

Forward warping moves every ground pixel of a neighbour to where this frame's camera would see it.
Where several neighbours agree, it becomes the label of the walkable surface, seen or hidden.
"""

import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics


def warp_depth(
    depth_m: NDArray[np.float32],
    source: Intrinsics,
    target: Intrinsics,
    source_to_target: NDArray[np.floating],
    size: tuple[int, int],
    *,
    as_published: bool = False,
) -> NDArray[np.float32]:
    """Forward-warp a depth map into another camera: sparse, with holes.

    Args:
        depth_m: float32 (h, w), metres along the optical axis; 0 where there is nothing to warp.
        source: the camera of ``depth_m``, in its pixels.
        target: the other camera, in the pixels of ``size``.
        source_to_target: (4, 4), from the source camera's axes to the target's.
        size: (H, W) of the result.
        as_published: cut coordinates off to the pixel below, leave out row and column 0, and
            where several points meet keep the last in row-major order, as the paper's code does.
            Otherwise coordinates are rounded and the nearest point is kept: right to half a pixel,
            and a far point never covers a near one.

    Returns:
        float32 (H, W), metres along the target's optical axis, 0 where no point fell.
    """
    height, width = size
    rows, columns = np.nonzero(depth_m > 0)
    depth = depth_m[rows, columns]
    project = _project_as_published if as_published else _project
    u, v, z = project(columns, rows, depth, source, target, source_to_target)
    lowest = np.nextafter(0, 1) if as_published else 0
    seen = (z > 0) & (u >= lowest) & (v >= lowest) & (u < width) & (v < height)
    pixels = v[seen].astype(np.int64) * width + u[seen].astype(np.int64)
    values = z[seen].astype(np.float32)
    if as_published:
        warped = np.zeros(height * width, np.float32)
        warped[pixels] = values
    else:
        warped = np.full(height * width, np.inf, np.float32)
        np.minimum.at(warped, pixels, values)
        warped[np.isinf(warped)] = 0
    return warped.reshape(size)


def aggregate(warped_m: NDArray[np.float32], least_hits: int) -> NDArray[np.float32]:
    """Eq. 1 and 2: the median of the depths that fell on a pixel, where enough frames agree.

    Args:
        warped_m: float32 (N, H, W), metres, 0 = none; one warped depth map a neighbour.
        least_hits: the paper's k: a pixel counts where more than k maps hold a depth.

    Returns:
        float32 (H, W), metres, 0 where too few frames saw ground.
    """
    size = warped_m.shape[1:]
    stack = warped_m.reshape(len(warped_m), -1)
    hits = (stack > 0).sum(axis=0)
    pixels = np.flatnonzero(hits > least_hits)
    values = np.ascontiguousarray(stack[:, pixels].T)
    values.sort(axis=1)  # zeros first: the depths are the last `hits` of each row
    first = values.shape[1] - hits[pixels]
    lower, upper = first + (hits[pixels] - 1) // 2, first + hits[pixels] // 2
    each = np.arange(len(pixels))
    median = np.zeros(stack.shape[1], np.float32)
    median[pixels] = (values[each, lower] + values[each, upper]) / 2
    return median.reshape(size)


def _project(
    columns: NDArray[np.int64],
    rows: NDArray[np.int64],
    depth_m: NDArray[np.float32],
    source: Intrinsics,
    target: Intrinsics,
    source_to_target: NDArray[np.floating],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Pixel coordinates, counted from the edge of pixel 0, and depth in the target."""
    # K_t (R (d K_s^-1 (u, v, 1)) + t): one 3x3 matrix for all that grows with the depth
    to_pixels = target.matrix
    along = to_pixels @ source_to_target[:3, :3] @ np.linalg.inv(source.matrix)
    shift = to_pixels @ source_to_target[:3, 3]
    x, y, z = (
        (row[0] * columns + row[1] * rows + row[2]) * depth_m + offset
        for row, offset in zip(along, shift, strict=True)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        return x / z + 0.5, y / z + 0.5, z


def _project_as_published(
    columns: NDArray[np.int64],
    rows: NDArray[np.int64],
    depth_m: NDArray[np.float32],
    source: Intrinsics,
    target: Intrinsics,
    source_to_target: NDArray[np.floating],
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """The same counted from pixel 0's index, in the float32 steps of the paper's code.

    Coordinates are cut off afterwards, so a whole number must not become a little less: the order
    of the operations matters, down to the fused multiply-add that multiplies by the intrinsics.
    """
    single = np.float32
    moved = source_to_target.astype(single)
    x = (single(1 / source.fx) * columns.astype(single) + single(-source.cx / source.fx)) * depth_m
    y = (single(1 / source.fy) * rows.astype(single) + single(-source.cy / source.fy)) * depth_m
    x, y, z = (row[0] * x + row[1] * y + row[2] * depth_m + row[3] for row in moved[:3])

    def pixels(focal: float, centre: float, across: NDArray[np.float32]) -> NDArray[np.float32]:
        product = (single(focal) * across).astype(np.float64)
        fused = (float(single(centre)) * z.astype(np.float64) + product).astype(single)
        quotient: NDArray[np.float32] = fused / (z + single(1e-7))
        return quotient

    return pixels(target.fx, target.cx, x), pixels(target.fy, target.cy, y), z
