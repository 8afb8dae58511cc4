"""Steady maps in a video: each frame's are mixed with those before, moved as the camera moved."""

from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import GroundPlaneError
from footprints_edge.foundation.opencv import opencv
from footprints_edge.foundation.types import Floats, Mask
from footprints_edge.maps.ground_maps import GroundMaps, MapsT
from footprints_edge.video.ground_motion import GroundMotion

MEMORY = 0.75
"""How much of a pixel's value comes from the frames before: `fp-bench steadiness` gains little
from more, and edges that move begin to lag."""

_LEAST_GROUND = 300
"""Pixels of ground that its motion is read off; with fewer, ground moves as what is seen."""

_SAMPLES = 600
_OFF_PX = 1.0
"""A pixel of the ground that moved so much differently did not move as the ground."""

_NEAREST_M = 0.05
_CHANGED = 20.0
"""Where the grey levels differ by more after alignment, something else is seen now: no memory."""


@dataclass(frozen=True, eq=False)
class _Memory:
    """The frame before: its grey picture, and its steady maps."""

    grey: NDArray[np.uint8]
    prediction: GroundMaps


class Tracker:
    """Keeps the maps of a video steady. It has a state: one object a video, frames in order."""

    def __init__(self) -> None:
        """Begins without a memory.

        Raises:
            VideoError: If OpenCV is missing.
        """
        self._cv2 = opencv()
        self._flow = self._cv2.DISOpticalFlow_create(self._cv2.DISOPTICAL_FLOW_PRESET_FAST)
        self._before: _Memory | None = None

    def update(self, prediction: MapsT) -> MapsT:
        """The steady version of the next frame's prediction.

        What is seen moves by optical flow, the ground by its plane's homography, which flow on
        visible ground gives; both depths change with the way that the camera went. A pixel that
        nothing of the last frame moves to, or where the picture has changed, is as the network
        says.

        Args:
            prediction: Of the next frame, as `Model.predict` made it.

        Returns:
            The same prediction with other probabilities and depths. After a cut, or a change of
            size, it is the given one.
        """
        grey = self._grey(prediction)
        steady = prediction
        if self._before is not None and self._before.grey.shape == grey.shape:
            steady = self._mixed(prediction, grey, self._before)
        self._before = _Memory(grey, steady)
        return steady

    def _grey(self, prediction: GroundMaps) -> NDArray[np.uint8]:
        height, width = prediction.map_size
        small = self._cv2.resize(
            prediction.rgb, (width, height), interpolation=self._cv2.INTER_AREA
        )
        grey: NDArray[np.uint8] = self._cv2.cvtColor(small, self._cv2.COLOR_RGB2GRAY)
        return grey

    def _mixed(self, now: MapsT, grey: NDArray[np.uint8], before: _Memory) -> MapsT:
        then = before.prediction
        flow = self._flow.calc(grey, before.grey, None)
        height, width = grey.shape
        seen_at = flow + np.dstack(np.meshgrid(np.arange(width), np.arange(height)))
        seen_at = seen_at.astype(np.float32)
        change = np.abs(self._moved(before.grey, seen_at) - grey)
        change = np.nan_to_num(change, nan=255)  # a running mean would carry NaN on
        alike = self._cv2.blur(change, (5, 5)) < _CHANGED
        motion = self._ground_motion(now, flow, alike)
        if motion is None:
            ground_at, farther, ground_alike = seen_at, np.ones(grey.shape, np.float32), alike
        else:
            ground_at, farther = motion.before((height, width))
            ground_alike = np.ones_like(alike)  # what hides the ground does not change it
        return now.with_maps(
            visible_ground_probability=_mixed(
                now.visible_ground_probability,
                self._moved(then.visible_ground_probability, seen_at),
                alike,
            ),
            ground_probability=_mixed(
                now.ground_probability,
                self._moved(then.ground_probability, ground_at),
                ground_alike,
            ),
            visible_depth_m=_mixed_depth(
                now.visible_depth_m,
                _depth_now(self._moved(then.visible_depth_m, seen_at), motion, now),
                alike,
            ),
            unmasked_ground_depth_m=_mixed_depth(
                now.unmasked_ground_depth_m,
                self._moved(then.unmasked_ground_depth_m, ground_at) / farther,
                ground_alike,
            ),
        )

    def _moved(self, values: NDArray[Any], at: Floats) -> Floats:
        """The values that were where `at` (h, w, 2) says; NaN from beyond the border."""
        found: Floats = self._cv2.remap(
            values.astype(np.float32), at, None, self._cv2.INTER_LINEAR, borderValue=np.nan
        )
        return found

    def _ground_motion(self, now: GroundMaps, flow: Floats, alike: Mask) -> GroundMotion | None:
        """How the ground moved, as its visible part shows; None where there is too little."""
        cv2 = self._cv2
        there = np.flatnonzero(now.visible_ground & alike)
        if len(there) < _LEAST_GROUND:
            return None
        there = there[:: max(1, len(there) // _SAMPLES)]
        columns, rows = there % flow.shape[1], there // flow.shape[1]
        pixels = np.stack([columns, rows], axis=1).astype(np.float32)
        homography, inliers = cv2.findHomography(
            pixels, pixels + flow[rows, columns], cv2.RANSAC, _OFF_PX
        )
        if homography is None or inliers.mean() < 0.5:
            return None
        return GroundMotion.from_homography(homography, now.intrinsics)


def _depth_now(depth_before_m: Floats, motion: GroundMotion | None, now: GroundMaps) -> Floats:
    """What was seen before, as far away as it is now; NaN where nobody knows."""
    if motion is not None:
        with suppress(GroundPlaneError):
            return motion.now_from_before(depth_before_m, now.ground_plane())
    return np.full_like(depth_before_m, np.nan)


def _mixed(now: Floats, then: Floats, where: Mask) -> Floats:
    """A map with the memory in it, where there is one."""
    mixed: Floats = np.where(
        where & np.isfinite(then), now + np.float32(MEMORY) * (then - now), now
    )
    return mixed


def _mixed_depth(now_m: Floats, then_m: Floats, where: Mask) -> Floats:
    """The same of depths, by their inverse, in which planes are flat."""
    then_m = np.where(then_m > _NEAREST_M, then_m, np.float32(np.nan))
    return np.reciprocal(_mixed(np.reciprocal(now_m), np.reciprocal(then_m), where))
