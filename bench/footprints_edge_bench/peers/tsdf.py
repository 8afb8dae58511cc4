"""The encoding of a depth picture for SSCNet: a flipped, truncated signed distance function."""

import numpy as np

from footprints_edge.foundation.types import Floats
from footprints_edge.geometry.camera import Intrinsics

TRUNCATION_M = 0.24
"""Distance at which the encoding has fallen to 0."""


def flipped_tsdf(
    depth_m: Floats,
    camera: Intrinsics,
    grid: tuple[int, int, int],
    voxel_m: float,
    camera_height_m: float = 1.2,
) -> Floats:
    """Encodes a depth picture of a level camera (Song et al. 2017, section 3.1).

    At a voxel at distance d from the nearest surface, anywhere and not only along the ray, stands
    sign * (1 - d / 0.24 m), not below 0: 1 at the surface, so that the steepest change is there.
    The sign is that of seen space; unseen space behind surfaces has the other.

    Args:
        depth_m: float32 (H, W), metres along the optical axis, 0 where there is none.
        camera: the camera in pixels of the depth picture.
        grid: voxels across, up, and ahead.
        voxel_m: side of a voxel.
        camera_height_m: height of the camera above the floor of the grid.

    Returns:
        float32 (across, up, ahead), from -1 to 1.
    """
    from scipy.ndimage import distance_transform_edt

    height, width = depth_m.shape
    across, up, ahead = grid
    rows, columns = np.nonzero(depth_m > 0)
    z = depth_m[rows, columns]
    x = (columns - camera.cx) / camera.fx * z
    y = camera_height_m - (rows - camera.cy) / camera.fy * z
    place = np.floor(np.stack([x / voxel_m + across / 2, y / voxel_m, z / voxel_m])).astype(int)
    inside = ((place >= 0) & (place < np.array(grid)[:, None])).all(0)
    empty = np.ones(grid, bool)
    empty[tuple(place[:, inside])] = False
    distance_m = voxel_m * distance_transform_edt(empty).astype(np.float32)
    encoded = np.maximum(1 - distance_m / np.float32(TRUNCATION_M), 0)
    # the depth seen where each voxel's centre projects to
    centre_z = (np.arange(ahead) + 0.5) * voxel_m
    centre_x = (np.arange(across) + 0.5 - across / 2) * voxel_m
    centre_y = camera_height_m - (np.arange(up) + 0.5) * voxel_m
    column = np.rint(camera.cx + camera.fx * centre_x[:, None] / centre_z).astype(int)
    row = np.rint(camera.cy + camera.fy * centre_y[:, None] / centre_z).astype(int)
    in_view = ((column >= 0) & (column < width))[:, None] & ((row >= 0) & (row < height))[None]
    at = row.clip(0, height - 1)[None] * width + column.clip(0, width - 1)[:, None]
    seen = in_view & (depth_m.take(at) > centre_z)
    flipped: Floats = np.where(seen, encoded, -encoded)
    return flipped
