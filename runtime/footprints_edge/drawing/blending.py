"""Alpha blending, and antialiased coverage of lines and areas.

Functions take a list of the pixels to paint, float32 (3, n): with one row per channel each step
reads contiguous memory.
"""

import math

import numpy as np

from footprints_edge.drawing.style import HATCH_PERIOD, HATCH_STRIPE, INK, WHITE
from footprints_edge.foundation.types import Floats

WHITE_PIXEL, INK_PIXEL = (np.array(rgb, np.float32)[:, None] for rgb in (WHITE, INK))


def paint(pixels: Floats, colour: Floats, opacity: Floats) -> None:
    """Blends a colour into pixels, in place.

    Args:
        pixels: float32 (3, n).
        colour: float32 (3, 1) or (3, n).
        opacity: float32 (n,), from 0 to 1.
    """
    where = np.flatnonzero(opacity > 0)
    if 2 * where.size > opacity.size:
        mixed = colour - pixels
        mixed *= opacity
        pixels += mixed
    else:  # lines cover few pixels
        under = pixels.take(where, axis=1)
        over = colour if colour.shape[1] == 1 else colour.take(where, axis=1)
        pixels[:, where] = under + opacity[where] * (over - under)


def inside(distance_px: Floats) -> Floats:
    """Antialiased coverage, 0 to 1, of pixels whose centres are `distance_px` inside an edge."""
    coverage: Floats = np.clip(distance_px + np.float32(0.5), 0, 1)
    return coverage


def hatch(
    pixels: Floats, colour: Floats, opacity: Floats, diagonal_px: Floats, pen_px: float
) -> None:
    """Draws diagonal stripes with a light rim on one side, and darkens the picture in between.

    The contrast keeps the stripes visible on any picture, in any colour, and in grey print.

    Args:
        pixels: float32 (3, n), modified in place.
        colour: float32 (3, n).
        opacity: float32 (n,).
        diagonal_px: float32 (n,), each pixel's row plus its column.
        pen_px: Width of a line.
    """
    period_px, stripe_px = HATCH_PERIOD * pen_px, HATCH_STRIPE * pen_px
    periods = diagonal_px * np.float32(1 / (np.sqrt(2) * period_px))
    position_px = (periods - np.floor(periods) - np.float32(0.5)) * np.float32(period_px)
    stripe = inside(stripe_px / 2 - np.abs(position_px))
    rim = inside(0.6 * pen_px - np.abs(position_px + stripe_px / 2))
    paint(pixels, INK_PIXEL, 0.45 * opacity * (1 - stripe))
    paint(pixels, colour, opacity * (0.12 + 0.83 * stripe))
    paint(pixels, WHITE_PIXEL, 0.8 * opacity * rim)


def blurred_edge_px(blur_px: float) -> Floats:
    """float32 (256,): signed distance to a blurred mask's edge by grey level, positive inside.

    A straight edge blurred by a Gaussian is the Gaussian's cumulative distribution over the
    distance. Its inverse recovers the distance; the blur rounds off the maps' pixels.
    """
    offsets_px = np.linspace(-4, 4, 401) * blur_px
    level = [127.5 * (1 + math.erf(x / (math.sqrt(2) * blur_px))) for x in offsets_px]
    levels = (np.arange(256) + 0.5) * 255 / 256
    distances_px = np.interp(levels, level, offsets_px).astype(np.float32)
    distances_px[[0, -1]] = -1e3, 1e3
    return distances_px
