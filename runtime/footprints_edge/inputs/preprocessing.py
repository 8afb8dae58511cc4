"""The one preprocessing of inference, calibration, accuracy evaluation and benchmark.

Only the size changes here: scaling and normalisation of the values are inside the model file.
"""

import math
from functools import lru_cache

import numpy as np
from PIL import Image

from footprints_edge.foundation.types import Rgb, Size

STRIDE = 32
"""Networks halve the picture five times: sides must be multiples of this."""

BUDGET_PX = 256 * 448
"""Pixels that the network sees, whatever the picture's shape."""

FILTERS = {"lanczos": Image.Resampling.LANCZOS, "bilinear": Image.Resampling.BILINEAR}
"""Resize filters that a model's metadata may name; both antialias."""

ENOUGH = 2
"""A picture is decoded no smaller than so many times the sides of the network's input: what that
changes is less than what the JPEG itself did to the picture."""

_REDUCING_GAP = 3.0
"""Larger pictures than twice this are averaged over whole blocks first, to no less than this many
times the sides of the result: three times as fast, and off by a level of 255 at most pixels."""

_MOST_PX = 1.15 * BUDGET_PX
_AREA_WEIGHT = 0.25  # a squeeze of 4 % is as bad as 16 % too many or too few pixels


@lru_cache(maxsize=1024)
def working_size(image_size: Size) -> Size:
    """The size at which a network with free input size looks at a picture.

    Of all pairs of multiples of 32 with at most 1.15 times `BUDGET_PX` pixels, the one that
    keeps the picture's shape and the budget best: (256, 448) for 16:9, (448, 256) for 9:16,
    (288, 384) for 4:3. The most extreme panorama gets (64, 2048): a network that pads by
    reflection needs two pixels where the picture is smallest.

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
        squeeze = abs(math.log(w / h) - log_aspect)
        return squeeze + _AREA_WEIGHT * abs(math.log(h * w / BUDGET_PX))

    return min(candidates, key=cost)


def enough_for(size: Size) -> Size:
    """How much of a picture is worth decoding for a network's input of a size (h, w)."""
    return ENOUGH * size[0], ENOUGH * size[1]


def preprocess(rgb: Rgb, size: Size, filter: str = "lanczos") -> Rgb:
    """The network's input: the whole picture, resized.

    Args:
        rgb: uint8 (H, W, 3), upright, red, green, blue: at its own size, or such as
            `enough_for` says.
        size: (h, w) of the result.
        filter: Key of `FILTERS`, from the model's metadata.

    Returns:
        uint8 (1, h, w, 3).
    """
    height, width = size
    resized = Image.fromarray(rgb).resize(
        (width, height), FILTERS[filter], reducing_gap=_REDUCING_GAP
    )
    return np.asarray(resized)[None]
