"""Temporal smoothing: each frame's maps are blended with the motion-compensated previous ones."""

from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import GroundPlaneError, MissingMapError
from footprints_edge.foundation.opencv import opencv
from footprints_edge.foundation.types import Floats, Mask, Size
from footprints_edge.maps.ground_maps import GroundMaps, MapsT
from footprints_edge.video.ground_motion import GroundMotion

MEMORY = 0.75
"""Weight of the previous frames in a pixel's value. More hardly reduces flicker (`fp-bench
flicker`), and moving edges begin to lag."""

_MIN_GROUND_PX = 300
"""Ground pixels needed to estimate its motion; with fewer, the ground moves by optical flow."""

_SAMPLES = 600
_RANSAC_PX = 1.0
"""Reprojection error above which a ground pixel is an outlier of the ground's motion."""

_NEAREST_M = 0.05
_CHANGED_LEVELS = 20.0
"""Grey level difference after alignment above which the surface has changed: no smoothing."""


@dataclass(frozen=True, eq=False)
class _PreviousFrame:
    """The grey picture and the smoothed maps of the previous frame."""

    grey: NDArray[np.uint8]
    prediction: GroundMaps


class Tracker:
    """Smooths the maps of a video over time. It is stateful: use one per video, frames in order."""

    def __init__(self) -> None:
        """Starts without a previous frame.

        Raises:
            VideoError: If OpenCV is missing.
        """
        self._cv2 = opencv()
        self._flow = self._cv2.DISOpticalFlow_create(self._cv2.DISOPTICAL_FLOW_PRESET_FAST)
        self._previous: _PreviousFrame | None = None

    def update(self, prediction: MapsT) -> MapsT:
        """Smooths the prediction of the next frame.

        Visible surfaces move by optical flow. The ground moves by its plane's homography, which is
        fitted to the flow on visible ground. Both depths follow the camera's motion. A pixel keeps
        the network's values if nothing in the previous frame maps to it, or if the picture has
        changed there.

        Args:
            prediction: The prediction of the next frame, from `Model.predict`.

        Returns:
            The prediction with smoothed probabilities and depths. After a cut, or a change of
            size, its values are the given ones.
        """
        grey = self._grey(prediction)
        smoothed = prediction
        if self._previous is not None and self._previous.grey.shape == grey.shape:
            smoothed = self._smooth(prediction, grey, self._previous)
        self._previous = _PreviousFrame(grey, smoothed)
        return smoothed

    def _grey(self, prediction: GroundMaps) -> NDArray[np.uint8]:
        height, width = prediction.map_size
        grey = self._cv2.cvtColor(prediction.rgb, self._cv2.COLOR_RGB2GRAY)
        small: NDArray[np.uint8] = self._cv2.resize(
            grey, (width, height), interpolation=self._cv2.INTER_AREA
        )
        return small

    def _smooth(self, now: MapsT, grey: NDArray[np.uint8], previous: _PreviousFrame) -> MapsT:
        before = previous.prediction
        flow = self._flow.calc(grey, previous.grey, None)
        height, width = grey.shape
        flow_xy = flow + _pixels((height, width))
        change = np.abs(self._warp(previous.grey, flow_xy) - grey)
        change = np.nan_to_num(change, nan=255)  # a moving mean would spread NaN
        unchanged = self._cv2.blur(change, (5, 5)) < _CHANGED_LEVELS
        motion = self._ground_motion(now, flow, unchanged)
        if motion is None:
            ground_xy, depth_ratio = flow_xy, np.ones(grey.shape, np.float32)
            ground_unchanged = unchanged
        else:
            ground_xy, depth_ratio = motion.before((height, width))
            ground_unchanged = np.ones_like(unchanged)  # an occluder does not change the ground
        moved = {
            "visible_ground_probability": (flow_xy, unchanged),
            "ground_probability": (ground_xy, ground_unchanged),
            "visible_depth_m": (flow_xy, unchanged),
            "unmasked_ground_depth_m": (ground_xy, ground_unchanged),
        }
        if now.laid_onto is not None and now.pose.everything:  # it lies on the plane that is known
            del moved["unmasked_ground_depth_m"]
        smoothed: dict[str, Floats] = {}
        for name, (previous_xy, where) in moved.items():
            if not now.has(name):  # the model file lacks it
                continue
            warped = self._warp(getattr(before, name), previous_xy)
            if name == "visible_depth_m":
                warped = _depth_now(warped, motion, now)
            if name == "unmasked_ground_depth_m":
                warped = warped / depth_ratio
            blend = _blend_depth if name.endswith("_m") else _blend
            smoothed[name] = blend(getattr(now, name), warped, where)
        if now.laid_onto is not None and not now.pose.everything:
            now = replace(now, least_error_m=now.laid_onto.error_m)
        return now.with_maps(laid_onto=None, **smoothed)

    def _warp(self, values: NDArray[Any], previous_xy: Floats) -> Floats:
        """Samples previous values at pixels (h, w, 2); NaN outside the picture."""
        warped: Floats = self._cv2.remap(
            values.astype(np.float32, copy=False),
            previous_xy,
            None,
            self._cv2.INTER_LINEAR,
            borderValue=np.nan,
        )
        return warped

    def _ground_motion(self, now: GroundMaps, flow: Floats, unchanged: Mask) -> GroundMotion | None:
        """Fits the ground's motion to the flow on visible ground; None if there is too little."""
        cv2 = self._cv2
        if not now.has("visible_ground_probability"):
            return None
        samples = np.flatnonzero(now.visible_ground & unchanged)
        if len(samples) < _MIN_GROUND_PX:
            return None
        samples = samples[:: max(1, len(samples) // _SAMPLES)]
        columns, rows = samples % flow.shape[1], samples // flow.shape[1]
        pixels = np.stack([columns, rows], axis=1).astype(np.float32)
        homography, inliers = cv2.findHomography(
            pixels, pixels + flow[rows, columns], cv2.RANSAC, _RANSAC_PX
        )
        if homography is None or inliers.mean() < 0.5:
            return None
        return GroundMotion.from_homography(homography, now.intrinsics)


def _depth_now(depth_before_m: Floats, motion: GroundMotion | None, now: GroundMaps) -> Floats:
    """Converts previous depths to the current camera; all NaN without motion or ground plane."""
    if motion is not None:
        with suppress(GroundPlaneError, MissingMapError):
            return motion.now_from_before(depth_before_m, now.ground_plane())
    return np.full_like(depth_before_m, np.nan)


@lru_cache(maxsize=4)
def _pixels(size: Size) -> Floats:
    """float32 (h, w, 2), x and y of each pixel."""
    height, width = size
    return np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).astype(np.float32)


def _blend(now: Floats, before: Floats, where: Mask) -> Floats:
    """Blends a map with the previous one, where that is valid."""
    blended: Floats = before - now
    blended *= np.float32(MEMORY)
    blended += now
    np.copyto(blended, now, where=~(where & np.isfinite(before)))
    return blended


def _blend_depth(now_m: Floats, before_m: Floats, where: Mask) -> Floats:
    """Blends depths as inverse depth, in which planes are affine."""
    with np.errstate(divide="ignore"):  # where it is zero, it is not used
        before = np.reciprocal(before_m)
        blended: Floats = np.reciprocal(_blend(np.reciprocal(now_m), before, where))
    np.copyto(blended, now_m, where=~(before_m > _NEAREST_M))
    return blended
