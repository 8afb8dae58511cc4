"""The colour map of distance: a colour means the same number of metres in every picture.

The scale is logarithmic from 0.5 m to 20 m, the range in which hidden depths are evaluated, and
runs from pale yellow (near) through red to indigo (far). It follows a path through Oklab at
constant speed: equal ratios of distance look equally different. Lightness falls monotonically, so
the order survives grey print and colour blindness.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Floats, Rgb

NEAREST_M = 0.5
FARTHEST_M = 20.0

_STEPS = 256
# (lightness, chroma, hue in degrees) in polar Oklab; all inside sRGB
_NEAR, _MIDDLE, _FAR = (0.94, 0.09, 98.0), (0.64, 0.183, 25.0), (0.33, 0.145, -75.0)

# Björn Ottosson, "A perceptual color space for image processing" (2020)
_LAB_TO_LMS = np.array(
    [
        [1.0, 0.3963377774, 0.2158037573],
        [1.0, -0.1055613458, -0.0638541728],
        [1.0, -0.0894841775, -1.2914855480],
    ]
)
_LMS_TO_LINEAR_RGB = np.array(
    [
        [4.0767416621, -3.3077115913, 0.2309699292],
        [-1.2684380046, 2.6097574011, -0.3413193965],
        [-0.0041960863, -0.7034186147, 1.7076147010],
    ]
)


def colours_of(depth_m: Floats) -> Rgb:
    """The colour of each distance, clipped at the ends of the scale.

    Args:
        depth_m: Metres, any shape; NaN counts as far.

    Returns:
        uint8 (..., 3).
    """
    colours: Rgb = colour_scale()[scale_position(depth_m)]
    return colours


def scale_position(depth_m: Floats) -> NDArray[np.intp]:
    """The index of each distance in `colour_scale`."""
    with np.errstate(invalid="ignore", divide="ignore"):
        fraction = np.asarray(np.log(depth_m / NEAREST_M) / np.log(FARTHEST_M / NEAREST_M))
    np.fmin(fraction, 1, out=fraction)  # of NaN and 1 it is 1
    np.maximum(fraction, 0, out=fraction)
    fraction *= _STEPS - 1
    position: NDArray[np.intp] = np.rint(fraction, out=fraction).astype(np.intp)
    return position


@lru_cache(maxsize=1)
def colour_scale() -> Rgb:
    """uint8 (256, 3), RGB: the scale from `NEAREST_M` to `FARTHEST_M`, in equal distance ratios."""
    lab = scale_in_oklab()
    linear = ((lab @ _LAB_TO_LMS.T) ** 3) @ _LMS_TO_LINEAR_RGB.T
    linear = np.clip(linear, 0, 1)
    srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    scale: Rgb = np.rint(255 * srgb).astype(np.uint8)
    scale.setflags(write=False)
    return scale


def scale_in_oklab() -> NDArray[np.float64]:
    """float64 (256, 3): the scale in Oklab (L, a, b), in equal steps."""
    fine = np.linspace(0, 1, 64 * _STEPS)
    lightness, chroma, hue_deg = (
        _parabola(fine, *values) for values in zip(_NEAR, _MIDDLE, _FAR, strict=True)
    )
    hue = np.radians(hue_deg)
    path = np.stack([lightness, chroma * np.cos(hue), chroma * np.sin(hue)], axis=1)
    length = np.concatenate([[0.0], np.linalg.norm(np.diff(path, axis=0), axis=1).cumsum()])
    even = np.linspace(0, length[-1], _STEPS)
    return np.stack([np.interp(even, length, path[:, i]) for i in range(3)], axis=1)


def _parabola(
    fraction: NDArray[np.float64], start: float, middle: float, end: float
) -> NDArray[np.float64]:
    """The parabola through `start` at 0, `middle` at one half and `end` at 1."""
    bend = 4 * middle - 2 * (start + end)
    return start + (end - start) * fraction + bend * fraction * (1 - fraction)
