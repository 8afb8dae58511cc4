"""The depth picture of a made room, in closed form: what the peers that need depth are timed on."""

import numpy as np

from footprints_edge.foundation.types import Floats, Size
from footprints_edge.geometry.camera import Intrinsics

DEPTH_SIZE: Size = (480, 640)
"""(H, W) of a structured-light camera."""


def depth_camera(size: Size = DEPTH_SIZE) -> Intrinsics:
    """A structured-light camera: 518.9 pixels of focal length at 640 columns."""
    focal_px = 518.9 * size[1] / 640
    return Intrinsics(focal_px, focal_px, (size[1] - 1) / 2, (size[0] - 1) / 2)


def room_depth_m(size: Size = DEPTH_SIZE) -> Floats:
    """A level camera 1.2 m above the floor of a room 4 m wide and 4.5 m deep, with a crate in it.

    Args:
        size: (H, W) of the picture.

    Returns:
        float32 (H, W), metres along the optical axis.
    """
    camera = depth_camera(size)
    x = ((np.arange(size[1]) - camera.cx) / camera.fx)[None, :]
    y = ((np.arange(size[0]) - camera.cy) / camera.fy)[:, None]
    with np.errstate(divide="ignore"):
        depth_m = np.minimum(2.0 / np.abs(x), 4.5)  # side walls, and the one ahead
        depth_m = np.minimum(depth_m, np.where(y > 0, 1.2 / y, 1.5 / -y))  # floor, ceiling
    crate = (np.abs(x * 2.2 - 0.2) < 0.4) & (y * 2.2 > 0.5) & (y * 2.2 < 1.2)
    room: Floats = np.where(crate, np.minimum(depth_m, 2.2), depth_m).astype(np.float32)
    return room
