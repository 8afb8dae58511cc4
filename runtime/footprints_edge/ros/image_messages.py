"""Pictures of `sensor_msgs/Image` and `CompressedImage` messages, of ROS 1 and 2."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import ImageError
from footprints_edge.foundation.opencv import opencv
from footprints_edge.foundation.types import Rgb
from footprints_edge.inputs.images import MAX_PIXELS, DecodedImage, decode

_CHANNELS = {
    "rgb8": (0, 1, 2),
    "bgr8": (2, 1, 0),
    "rgba8": (0, 1, 2),
    "bgra8": (2, 1, 0),
    "mono8": (0, 0, 0),
    "8UC1": (0, 0, 0),
    "8UC3": (2, 1, 0),
    "8UC4": (2, 1, 0),
    "rgb16": (0, 1, 2),
    "bgr16": (2, 1, 0),
    "rgba16": (0, 1, 2),
    "bgra16": (2, 1, 0),
    "mono16": (0, 0, 0),
}
"""Encodings by channel: which of them are red, green and blue. OpenCV's own are BGR."""

_BY_OPENCV = {
    "bayer_rggb8": ("COLOR_BayerRGGB2RGB", 1),
    "bayer_bggr8": ("COLOR_BayerBGGR2RGB", 1),
    "bayer_gbrg8": ("COLOR_BayerGBRG2RGB", 1),
    "bayer_grbg8": ("COLOR_BayerGRBG2RGB", 1),
    "yuv422": ("COLOR_YUV2RGB_UYVY", 2),
    "uyvy": ("COLOR_YUV2RGB_UYVY", 2),
    "yuv422_yuy2": ("COLOR_YUV2RGB_YUYV", 2),
    "yuyv": ("COLOR_YUV2RGB_YUYV", 2),
}
"""Encodings that OpenCV converts, with their bytes for each pixel."""

_DEPTHS = ("16UC1", "32FC1", "compressedDepth")


def picture_of(message: Any) -> DecodedImage:  # noqa: ANN401 - of rosbags, rclpy or rospy
    """The picture of an `Image` or a `CompressedImage`.

    Raises:
        ImageError: If the message holds no picture, or one of an encoding that is not supported.
        VideoError: If its encoding needs OpenCV, and it is missing.
    """
    if hasattr(message, "format"):
        return _decompressed(message)
    encoding, height, width = str(message.encoding), int(message.height), int(message.width)
    if any(name in encoding for name in _DEPTHS):
        raise ImageError(f"its encoding is {encoding!r}: depth, and no picture")
    if min(height, width) < 1 or height * width > MAX_PIXELS:
        raise ImageError(f"a picture cannot be {width} x {height} pixels")
    if encoding in _CHANNELS:
        channels = 4 if "a" in encoding or "C4" in encoding else 1 if _is_grey(encoding) else 3
        wide = encoding.endswith("16")
        pixels = _rows(message, width * channels * (2 if wide else 1))
        if wide:
            order = ">u2" if message.is_bigendian else "<u2"
            pixels = (pixels.view(order) >> 8).astype(np.uint8)
        rgb = pixels.reshape(height, width, channels)[..., list(_CHANNELS[encoding])]
        return DecodedImage(np.ascontiguousarray(rgb))
    if encoding in _BY_OPENCV:
        code, per_pixel = _BY_OPENCV[encoding]
        pixels = _rows(message, width * per_pixel)
        if height % 2 or width % 2:
            raise ImageError(f"{encoding} of {width} x {height} pixels: its sides must be even")
        cv2 = opencv()
        shape = (height, width) if per_pixel == 1 else (height, width, per_pixel)
        converted: Rgb = cv2.cvtColor(pixels.reshape(shape), getattr(cv2, code))
        return DecodedImage(converted)
    raise ImageError(
        f"its encoding is {encoding!r}; supported are {', '.join([*_CHANNELS, *_BY_OPENCV])}"
    )


def _is_grey(encoding: str) -> bool:
    return encoding.startswith("mono") or encoding.endswith("C1")


def _rows(message: Any, row_bytes: int) -> NDArray[np.uint8]:  # noqa: ANN401 - as above
    """uint8 (height, row_bytes): the rows without their padding."""
    height, step = int(message.height), int(message.step)
    data = np.frombuffer(message.data, np.uint8)
    if step < row_bytes or len(data) < height * step:
        raise ImageError(
            f"{message.encoding} of {message.width} x {height} pixels with rows of {step} bytes "
            f"does not fit its {len(data)} bytes of data"
        )
    return np.ascontiguousarray(data[: height * step].reshape(height, step)[:, :row_bytes])


def _decompressed(message: Any) -> DecodedImage:  # noqa: ANN401 - as above
    if any(name in message.format for name in _DEPTHS):
        raise ImageError(f"its format is {message.format!r}: depth, and no picture")
    return decode(bytes(message.data))
