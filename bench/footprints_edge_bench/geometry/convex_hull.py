"""The convex hull of a mask: the paper's baseline, and Matterport's region of evaluation."""

import numpy as np

from footprints_edge.foundation.types import Mask


def convex_hull(mask: Mask) -> Mask:
    """The smallest convex mask around a mask, pixels taken as squares; bool (H, W).

    scikit-image's, as in the published evaluation: another library's hull differs at the border
    by a pixel, and so would every figure that is compared with the paper's.
    """
    from skimage.morphology import convex_hull_image

    if not mask.any():
        return np.zeros_like(mask)
    hull: Mask = convex_hull_image(mask)
    return hull
