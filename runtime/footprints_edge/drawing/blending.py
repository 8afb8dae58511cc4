"""Mixing colours into pixels, and how much of a pixel a line or an area covers.

Pixels are lists of those that anything is painted on, float32 (3, n): one row a channel, so that
each step runs through memory once.
"""

import math

import numpy as np

from footprints_edge.drawing.style import HATCH_PERIOD, HATCH_STRIPE, INK, WHITE
from footprints_edge.foundation.types import Floats

WHITE_PIXEL, INK_PIXEL = (np.array(rgb, np.float32)[:, None] for rgb in (WHITE, INK))


def paint(pixels: Floats, colour: Floats, opacity: Floats) -> None:
    """Mixes a colour into pixels, in place.

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
    else:  # lines are few pixels
        under = pixels.take(where, axis=1)
        over = colour if colour.shape[1] == 1 else colour.take(where, axis=1)
        pixels[:, where] = under + opacity[where] * (over - under)


def inside(distance_px: Floats) -> Floats:
    """Coverage of a pixel, 0 to 1, whose centre is so far inside an edge: antialiasing."""
    coverage: Floats = np.clip(distance_px + np.float32(0.5), 0, 1)
    return coverage


def hatch(
    pixels: Floats, colour: Floats, opacity: Floats, diagonal_px: Floats, pen_px: float
) -> None:
    """Diagonal stripes of the colour, lit on one side, with the picture darkened in between.

    Light against dark: the stripes show on any picture, in any colour, and in grey print.

    Args:
        pixels: float32 (3, n), changed in place.
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
    """float32 (256,): how far inside (positive) a blurred mask's edge a pixel of each level is.

    A straight edge blurred by a Gaussian is that Gaussian's distribution function of the
    distance: its inverse gives the distance back, and the blur rounds off the maps' pixels.
    """
    away_px = np.linspace(-4, 4, 2001) * blur_px
    level = [127.5 * (1 + math.erf(x / (math.sqrt(2) * blur_px))) for x in away_px]
    distances_px = np.interp((np.arange(256) + 0.5) * 255 / 256, level, away_px).astype(np.float32)
    distances_px[[0, -1]] = -1e3, 1e3
    return distances_px
