"""How pictures look, in a few numbers: by which made ones are held against photos."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

LONGER_SIDE_PX = 320
"""Pictures are compared at this size: sharpness depends on it."""
_BLOCK_PX = 8

Picture = NDArray[np.uint8]


@dataclass(frozen=True)
class Appearance:
    """Numbers of one picture; brightness and colours run from 0 to 1, not linearised.

    Attributes:
        brightness: mean of luma.
        contrast: standard deviation of luma.
        dark: share of pixels below 0.1.
        bright: share of pixels above 0.95.
        saturation: mean of (largest - smallest) / largest of R, G and B.
        colourful: 95th percentile of largest - smallest.
        warmth: mean of R less mean of B.
        spectrum_slope: d log power / d log frequency from 1/32 to 1/3 cycles a pixel.
        edges: share of pixels where luma changes by more than 0.08 a pixel.
        flat: share of 8 x 8 blocks with a standard deviation of luma below 0.012.
        grain: median over blocks of the deviation of luma from its 3 x 3 mean.
    """

    brightness: float
    contrast: float
    dark: float
    bright: float
    saturation: float
    colourful: float
    warmth: float
    spectrum_slope: float
    edges: float
    flat: float
    grain: float


def appearance(picture: Picture) -> Appearance:
    """The numbers of a picture, uint8 RGB, after it was reduced to LONGER_SIDE_PX."""
    scale = LONGER_SIDE_PX / max(picture.shape[:2])
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    rgb = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=how).astype(np.float32) / 255
    luma = rgb @ np.array([0.299, 0.587, 0.114], np.float32)
    most, least = rgb.max(axis=2), rgb.min(axis=2)
    right, down = cv2.Sobel(luma, -1, 1, 0, scale=1 / 8), cv2.Sobel(luma, -1, 0, 1, scale=1 / 8)
    return Appearance(
        float(luma.mean()),
        float(luma.std()),
        float((luma < 0.1).mean()),
        float((luma > 0.95).mean()),
        float(((most - least) / np.maximum(most, 0.02)).mean()),
        float(np.quantile(most - least, 0.95)),
        float(rgb[..., 0].mean() - rgb[..., 2].mean()),
        _spectrum_slope(luma),
        float((np.hypot(right, down) > 0.08).mean()),
        float((_block_deviation(luma) < 0.012).mean()),
        float(np.median(_block_deviation(luma - cv2.blur(luma, (3, 3))))),
    )


def compare(made: Sequence[Appearance], photos: Sequence[Appearance]) -> dict[str, list[float]]:
    """For each number its median in made pictures, in photos, and how far apart the two lie.

    The last is the Kolmogorov-Smirnov distance: 0 where the distributions are one, 1 where no
    made picture could be a photo.
    """
    table = {}
    for name in asdict(made[0]):
        first, second = (np.array([asdict(one)[name] for one in each]) for each in (made, photos))
        at = np.concatenate([first, second])
        below = [np.searchsorted(np.sort(each), at, side="right") / len(each)
                 for each in (first, second)]  # fmt: skip
        apart = np.abs(below[0] - below[1]).max()
        numbers = (np.median(first), np.median(second), apart)
        table[name] = [round(float(number), 3) for number in numbers]
    return table


def _spectrum_slope(luma: NDArray[np.float32]) -> float:
    side = min(luma.shape)
    top, left = (luma.shape[0] - side) // 2, (luma.shape[1] - side) // 2
    square = luma[top : top + side, left : left + side]
    window = np.hanning(side)
    power = np.abs(np.fft.fft2((square - square.mean()) * np.outer(window, window))) ** 2
    frequency = np.hypot(np.fft.fftfreq(side)[:, None], np.fft.fftfreq(side))
    rings = np.geomspace(1 / 32, 1 / 3, 13)
    ring = np.digitize(frequency.ravel(), rings)
    mean = np.bincount(ring, power.ravel(), 14)[1:13] / np.bincount(ring, minlength=14)[1:13]
    middle = np.sqrt(rings[:-1] * rings[1:])
    return float(np.polyfit(np.log(middle), np.log(np.maximum(mean, 1e-12)), 1)[0])


def _block_deviation(luma: NDArray[np.float32]) -> NDArray[np.float32]:
    height, width = (side // _BLOCK_PX for side in luma.shape)
    blocks = luma[: height * _BLOCK_PX, : width * _BLOCK_PX]
    blocks = blocks.reshape(height, _BLOCK_PX, width, _BLOCK_PX)
    return np.asarray(blocks.std(axis=(1, 3)), np.float32)
