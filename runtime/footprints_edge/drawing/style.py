"""The style shared by all drawings: colours, tint and hatching."""

import numpy as np

from footprints_edge.foundation.types import Mask, Size

PAPER = (22, 24, 31)
"""Background of legends and captions."""

INK = (14, 16, 22)
"""Dark outlines, and the gaps between stripes."""

WHITE = (255, 255, 255)

FAINT = (170, 176, 188)
"""Secondary text and ticks."""

TINT = 0.62
"""Opacity of the distance's colour on visible ground; the rest is the picture in grey."""

HATCH_PERIOD, HATCH_STRIPE = 10.0, 4.4
"""Period and stripe width of the hatching of hidden ground, in line widths."""


def diagonal_stripes(size: Size, period_px: float, stripe_px: float) -> Mask:
    """Bool (H, W): diagonal stripes; period and stripe are measured along a row."""
    across = np.arange(size[0])[:, None] + np.arange(size[1])
    stripes: Mask = across % period_px < stripe_px
    return stripes
