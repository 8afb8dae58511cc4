"""Convex hull of a mask: a baseline of the paper, and the region of its footprint scores."""

import numpy as np

from footprints_edge.foundation.types import Mask


def convex_hull(mask: Mask) -> Mask:
    """The smallest convex mask around a mask, with pixels as squares; bool (H, W).

    The published evaluation uses scikit-image. Hulls of other libraries differ by a pixel at the
    border, and scores would no longer be comparable with the paper's.
    """
    from skimage.morphology import convex_hull_image

    if not mask.any():
        return np.zeros_like(mask)
    hull: Mask = convex_hull_image(mask)
    return hull
