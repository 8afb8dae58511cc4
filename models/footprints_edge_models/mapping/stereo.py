"""Depth and the road plane from one rectified stereo pair."""

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.mapping.floor_map import DepthFrame
from footprints_edge_models.mapping.planes import Plane, fit_plane

_MOST_DISPARITY_PX = 128
ROAD_M = 0.05
"""Points nearer to the plane than this are road."""


def stereo_depth_m(
    left: NDArray[np.uint8], right: NDArray[np.uint8], focal_times_baseline: float
) -> NDArray[np.float32]:
    """Depth of the left picture by OpenCV's semi-global matching.

    Args:
        left: uint8 (H, W, 3), RGB, rectified.
        right: uint8 (H, W, 3), RGB, rectified.
        focal_times_baseline: horizontal focal length in pixels times baseline in metres.

    Returns:
        float32 (H, W), metres, 0 where no match was found.
    """
    block = 5
    matcher = cv2.StereoSGBM.create(
        numDisparities=_MOST_DISPARITY_PX,
        blockSize=block,
        P1=8 * block**2,
        P2=32 * block**2,
        disp12MaxDiff=1,
        uniquenessRatio=10,
        speckleWindowSize=200,
        speckleRange=2,
        mode=cv2.STEREO_SGBM_MODE_SGBM_3WAY,
    )
    grey = [cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) for image in (left, right)]
    disparity_px = matcher.compute(*grey).astype(np.float32) / 16
    with np.errstate(divide="ignore"):
        depth_m = np.where(disparity_px > 1, focal_times_baseline / disparity_px, 0)
    return depth_m.astype(np.float32)


def fit_road(frame: DepthFrame, seed: int = 0) -> Plane | None:
    """The plane that most depth in the lower half of a street picture lies on, by RANSAC.

    Only planes below the camera and within 15 degrees of level count; None where fewer than a
    tenth of the points lie on any.
    """
    points = frame.points()
    lower = np.zeros(frame.depth_m.shape, bool)
    lower[len(lower) // 2 :] = True
    points = points[lower & (frame.depth_m > 0) & (frame.depth_m < 25)]
    if len(points) < 1000:
        return None
    camera = frame.camera_to_world[:3, 3]

    def road_like(normals: NDArray[np.float64], offsets: NDArray[np.float64]) -> NDArray[np.bool_]:
        upward = -np.sign(normals[:, 1])  # the camera's y axis points down
        below = upward * (normals @ camera - offsets) > 0
        level: NDArray[np.bool_] = np.abs(normals[:, 1]) >= np.cos(np.radians(15))
        return below & level

    plane = fit_plane(points, np.random.default_rng(seed), accept=road_like)
    if plane is None or (np.abs(plane.height_m(points)) < ROAD_M).mean() < 0.1:
        return None
    return plane.facing(np.array([0.0, -1.0, 0.0]))
