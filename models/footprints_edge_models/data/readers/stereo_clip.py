"""Rectified stereo clips: ``image_l/``, ``image_r/`` and ``calib.txt``."""

import logging
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import decode
from footprints_edge_models.data.readers.pictures import list_pictures
from footprints_edge_models.mapping.floor_map import DepthFrame, ground_by_depth
from footprints_edge_models.mapping.stereo import fit_road, stereo_depth_m
from footprints_edge_models.sample import NO, UNKNOWN, YES, Sample, shrunk

logger = logging.getLogger(__name__)

MOST_STEREO_GROUND_M = 30.0
"""Farther away, half a metre of depth is less than a disparity step: no label."""


def read_stereo_clip(folder: Path) -> Iterator[Sample]:
    """Rectified stereo pairs in ``image_l/`` and ``image_r/`` with KITTI's ``calib.txt``.

    The street is a plane fitted to the depth in front of the camera. Hidden ground has no label.
    """
    left, right = np.loadtxt(folder / "calib.txt").reshape(2, 3, 4)
    baseline_m = -right[0, 3] / right[0, 0]
    camera = Intrinsics(left[0, 0], left[1, 1], left[0, 2], left[1, 2])
    for image_path in list_pictures(folder / "image_l"):
        image = decode(image_path).rgb
        other = decode(folder / "image_r" / image_path.name).rgb
        depth_m = stereo_depth_m(image, other, camera.fx * baseline_m)
        frame = DepthFrame(depth_m, camera, np.eye(4))
        plane = fit_road(frame)
        if plane is None:
            logger.warning("%s: no road plane found, frame left out", image_path)
            continue
        # A disparity error of a third of a pixel grows with the square of the distance.
        blur_m = depth_m**2 / (3 * camera.fx * baseline_m)
        visible = ground_by_depth(frame, plane, np.minimum(0.1 + blur_m, 0.35))
        visible[(visible == YES) & (depth_m > MOST_STEREO_GROUND_M)] = UNKNOWN
        plane_depth_m = frame.depth_to_m(plane)
        ground = np.full(visible.shape, UNKNOWN, np.uint8)
        ground[plane_depth_m <= 0] = NO
        ground[visible == YES] = YES
        yield shrunk(
            Sample(
                f"{folder.name}/{image_path.stem}",
                image,
                camera,
                visible,
                ground,
                np.where(depth_m < 60, depth_m, 0).astype(np.float16),
                np.where(ground == YES, plane_depth_m, 0).astype(np.float16),
            )
        )
