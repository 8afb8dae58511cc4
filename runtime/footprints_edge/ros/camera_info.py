"""The camera that a `CameraInfo` message states."""

from collections.abc import Callable
from typing import Any

import numpy as np

from footprints_edge.errors import IntrinsicsError
from footprints_edge.foundation.types import Size
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.calibration import Calibration

_SAME_SHAPE = 0.01
"""Relative difference of a picture's aspect ratio from the camera's that is allowed."""


def camera_of(
    info: Any,  # noqa: ANN401 - a message of rosbags, rclpy or rospy
    *,
    rectified: bool = False,
) -> "Calibration | Callable[[Size], Intrinsics] | None":
    """The camera of the pictures that come with a `sensor_msgs/CameraInfo`, for `Model.predict`.

    `K` and `P` are for the whole sensor: a region of interest and binning are taken off them.

    Args:
        info: The message, of ROS 1 or 2.
        rectified: Whether the pictures are rectified already, as on a topic `image_rect`: then `P`
            holds, and no distortion.

    Returns:
        A `Calibration`, whose pictures `predict` rectifies; the intrinsics as a function of the
        picture's size where there is no distortion; None if the camera is not calibrated, which
        ROS states by a K of zeros.

    Raises:
        IntrinsicsError: If the numbers cannot be a camera, or the distortion is not supported.
    """
    name = "P" if rectified else "K"
    numbers = np.array(_either(info, name), np.float64)
    if not numbers.any():
        return None
    if numbers.size != (12 if rectified else 9):
        raise IntrinsicsError(f"CameraInfo: {name} has {numbers.size} numbers")
    matrix = numbers.reshape(3, -1)[:, :3].copy()
    roi = info.roi
    cropped = roi.width > 0 and roi.height > 0
    width, height = (roi.width, roi.height) if cropped else (info.width, info.height)
    if cropped:
        matrix[:2, 2] -= roi.x_offset, roi.y_offset
    full = Intrinsics(matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2])
    if min(width, height) < 1:  # not stated
        return lambda _: full
    size = height // max(1, info.binning_y), width // max(1, info.binning_x)
    camera = full.scaled((height, width), size)
    distortion = np.array([] if rectified else _either(info, "D"), np.float64)
    if distortion.any():
        return Calibration.of(size, camera.matrix, info.distortion_model, distortion)

    def at_size(picture: Size) -> Intrinsics:
        if abs(picture[1] / picture[0] * size[0] / size[1] - 1) > _SAME_SHAPE:
            raise IntrinsicsError(
                f"the picture is {picture[1]} x {picture[0]} pixels, its CameraInfo is for "
                f"{size[1]} x {size[0]}; give the right --topic, or the camera by --camera"
            )
        return camera.scaled(size, picture)

    return at_size


class LatestCamera:
    """The camera of the latest `CameraInfo`: one object, with its remap, while that is the same.

    Attributes:
        camera: What `camera_of` gives; None before the first message.
    """

    def __init__(self, *, rectified: bool = False) -> None:
        """Starts without a camera.

        Args:
            rectified: As for `camera_of`.
        """
        self.camera: Calibration | Callable[[Size], Intrinsics] | None = None
        self._rectified = rectified
        self._said: object = None

    def read(self, info: Any) -> None:  # noqa: ANN401 - a message of any library
        """Takes the camera of a message.

        Raises:
            IntrinsicsError: As `camera_of`; the camera before it stays.
        """
        roi = info.roi
        said = (
            *(tuple(_either(info, name)) for name in "KDP"),
            (info.height, info.width, info.distortion_model, info.binning_x, info.binning_y),
            (roi.x_offset, roi.y_offset, roi.height, roi.width),
        )
        if said != self._said:
            self.camera = camera_of(info, rectified=self._rectified)
            self._said = said


def _either(info: Any, name: str) -> Any:  # noqa: ANN401 - a message of any library
    """A field whose name ROS 2 writes in lower case."""
    return getattr(info, name.lower()) if hasattr(info, name.lower()) else getattr(info, name)
