"""The look that all pictures share: colours, tint and hatching."""

import numpy as np

from footprints_edge.foundation.types import Mask, Size

PAPER = (22, 24, 31)
"""Background of legends and captions."""

INK = (14, 16, 22)
"""Dark outlines, and the dark between stripes."""

WHITE = (255, 255, 255)

FAINT = (170, 176, 188)
"""Letters and ticks of less weight."""

TINT = 0.62
"""Share of the distance's colour on visible ground; the rest is the picture in grey."""

HATCH_PERIOD, HATCH_STRIPE = 10.0, 4.4
"""Across the stripes of hidden ground, in widths of a line: a period, and a stripe in it."""


def diagonal_stripes(size: Size, period_px: float, stripe_px: float) -> Mask:
    """Bool (H, W): diagonal stripes, measured along a row."""
    across = np.arange(size[0])[:, None] + np.arange(size[1])
    stripes: Mask = across % period_px < stripe_px
    return stripes
