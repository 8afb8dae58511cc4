"""The one preprocessing function for inference, calibration, accuracy evaluation and benchmarks.

It only resizes: scaling and normalisation of the values are inside the model file.
"""

import math
from functools import lru_cache

import numpy as np
from PIL import Image

from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.parallel.bands import bands, on_bands

STRIDE = 32
"""Networks halve the picture five times, so both sides must be multiples of this."""

BUDGET_PX = 256 * 448
"""Target number of input pixels, for pictures of any shape."""

FILTERS = {
    "lanczos": Image.Resampling.LANCZOS,
    "hamming": Image.Resampling.HAMMING,
    "bilinear": Image.Resampling.BILINEAR,
}
"""Resize filters that a model's metadata may name; all antialias."""

FILTER = "lanczos"
"""The filter of the networks trained here, in training too."""

ENOUGH = 2
"""A picture is decoded at no less than this many times the sides of the network's input: the effect
is smaller than that of the JPEG compression itself."""

_REDUCING_GAP = 3.0
"""Pictures larger than twice this factor are first averaged over whole blocks, to no less than this
factor times the result's sides: three times as fast, and most pixels differ by at most 1 of 255."""

_WHOLE_PX = 32_000_000
"""Pictures with more pixels are averaged in strips: a copy of the whole would fill the memory."""

_STRIP_PX = 2**22


_SQUEEZE = 1.05
"""Pillow goes along x first where a picture shrinks along y by at most this factor more than along
x, as all usual ones do. Since version 13 it goes along y first where that is faster."""

_MOST_PX = 1.15 * BUDGET_PX
_AREA_WEIGHT = 0.25  # a distortion of 4 % is as bad as 16 % too many or too few pixels


@lru_cache(maxsize=1024)
def working_size(image_size: Size) -> Size:
    """The input size of a network with dynamic input size for a picture.

    Both sides are multiples of 32, with at most 1.15 times `BUDGET_PX` pixels in all. Among these
    sizes it is the best trade-off between the picture's shape and the budget: (256, 448) for 16:9,
    (448, 256) for 9:16, (288, 384) for 4:3. The most extreme panorama gets (64, 2048): a network
    that pads by reflection needs two pixels at its lowest resolution.

    Args:
        image_size: (H, W) of the upright picture.

    Returns:
        (h, w), both multiples of 32.
    """
    height, width = image_size
    if height > width:
        tall = working_size((width, height))
        return tall[1], tall[0]
    log_aspect = math.log(width / height)
    most = int(_MOST_PX)
    candidates = (
        (h, w)
        for h in range(2 * STRIDE, math.isqrt(most) + 1, STRIDE)
        for w in range(h, most // h + 1, STRIDE)
    )

    def cost(size: Size) -> float:
        h, w = size
        distortion = abs(math.log(w / h) - log_aspect)
        return distortion + _AREA_WEIGHT * abs(math.log(h * w / BUDGET_PX))

    return min(candidates, key=cost)


def enough_for(size: Size) -> Size:
    """The picture size (H, W) that is worth decoding for a network's input size (h, w)."""
    return ENOUGH * size[0], ENOUGH * size[1]


def preprocess(rgb: Rgb, size: Size, filter: str = FILTER, threads: int = 1) -> Rgb:
    """Resizes the whole picture to the network's input.

    Args:
        rgb: uint8 (H, W, 3), upright RGB, at full size or at least at the size of `enough_for`.
        size: (h, w) of the result.
        filter: Key of `FILTERS`, from the model's metadata.
        threads: Threads to share the work; the result does not depend on it.

    Returns:
        uint8 (1, h, w, 3).
    """
    return resized(rgb, size, filter, threads)[None]


def resized(
    rgb: Rgb,
    size: Size,
    filter: str = FILTER,
    threads: int = 1,
    reducing_gap: float | None = _REDUCING_GAP,
) -> Rgb:
    """The picture, uint8 (H, W, 3), at another size (h, w), antialiased; see `preprocess`.

    A very large picture is averaged over whole blocks first, whatever `reducing_gap` says.
    """
    (high, wide), (height, width) = rgb.shape[:2], size
    if high * wide > _WHOLE_PX:
        return _resized_in_strips(rgb, size, filter, reducing_gap or _REDUCING_GAP)
    if _goes_along_x_first(rgb, size) and reducing_gap == _REDUCING_GAP:
        return _resized_in_bands(rgb, size, filter, threads)
    return np.asarray(
        Image.fromarray(rgb).resize((width, height), FILTERS[filter], reducing_gap=reducing_gap)
    )


def _goes_along_x_first(rgb: Rgb, size: Size) -> bool:
    """Whether it is resized along x first, whatever Pillow would do: as all usual pictures are."""
    (high, wide), (height, width) = rgb.shape[:2], size
    return bool(wide > width and high * width <= _SQUEEZE * wide * height)


def _resized_in_strips(rgb: Rgb, size: Size, filter: str, reducing_gap: float) -> Rgb:
    """What Pillow does with a `reducing_gap`, without a copy of the whole picture."""
    height, width = rgb.shape[0], rgb.shape[1]
    across = int(width / size[1] / reducing_gap) or 1
    down = int(height / size[0] / reducing_gap) or 1
    means = Image.new("RGB", (-(-width // across), -(-height // down)))
    rows = max(1, _STRIP_PX // width // down) * down
    for top in range(0, height, rows):
        strip = Image.fromarray(rgb[top : top + rows])
        means.paste(strip.reduce((across, down)), (0, top // down))
    box = (0, 0, width / across, height / down)
    if _goes_along_x_first(rgb, size) and reducing_gap == _REDUCING_GAP:
        means = means.resize((size[1], means.height), FILTERS[filter], (0, 0, box[2], means.height))
        box = (0, 0, size[1], box[3])
    return np.asarray(means.resize((size[1], size[0]), FILTERS[filter], box=box))


def _resized_in_bands(rgb: Rgb, size: Size, filter: str, threads: int) -> Rgb:
    """What Pillow's `resize` does: means of blocks, then along x, then along y.

    No row needs another one along x, and no column along y: threads share rows, then columns.
    """
    (high, wide), (height, width) = rgb.shape[:2], size
    resample = FILTERS[filter]
    blocks = (int(wide / width / _REDUCING_GAP) or 1, int(high / height / _REDUCING_GAP) or 1)
    narrow = Image.new("RGB", (width, -(-high // blocks[1])))
    out = np.empty((height, width, 3), np.uint8)

    def along_x(band: slice) -> None:
        image = Image.fromarray(rgb[band])
        if blocks != (1, 1):
            image = image.reduce(blocks)
        across = (0, 0, wide / blocks[0], image.height)  # the last block may be narrower
        image = image.resize((width, image.height), resample, across)
        narrow.paste(image, (0, band.start // blocks[1]))

    def along_y(band: slice) -> None:
        image = narrow.crop((band.start, 0, band.stop, narrow.height))
        down = (0, 0, image.width, high / blocks[1])
        out[:, band] = np.asarray(image.resize((image.width, height), resample, down))

    on_bands(along_x, bands(high, threads, blocks[1]))
    on_bands(along_y, bands(width, threads))
    return out
