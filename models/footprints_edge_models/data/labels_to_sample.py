"""Video labels as a training sample, by the rules of the paper's training.

The three pixel sets of eq. 3: ground that some frame saw (YES), untraversable pixels (NO), and all
others, the unknown pixels (UNSEEN). Where the probability of visible ground is undecided, and no
other frame saw ground, there is no label (UNKNOWN).
"""

import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.preprocessing import resized
from footprints_edge_models.sample import NO, UNKNOWN, UNSEEN, YES, Sample, nearest, within
from footprints_edge_models.video_labels.footprint_masks import (
    GROUND_PROBABILITY,
    NOT_GROUND_PROBABILITY,
    drop_large_regions,
)


def label_sample(
    name: str,
    image: NDArray[np.uint8],
    intrinsics: Intrinsics,
    *,
    ground_probability: NDArray[np.floating],
    ground_depth_m: NDArray[np.floating],
    visible_depth_m: NDArray[np.floating] | None = None,
    footprint_mask: NDArray[np.bool_] | None = None,
    moving: NDArray[np.bool_] | None = None,
) -> Sample:
    """A sample at the picture's size, or at ``LONGEST_SIDE_PX``; labels may be of any size.

    Args:
        name: for messages.
        image: uint8 (H, W, 3), RGB.
        intrinsics: in pixels of the picture.
        ground_probability: (h, w), of visible ground.
        ground_depth_m: (h, w), metres, of the walkable surface on the ray; 0 = none.
        visible_depth_m: (h, w), metres, 0 = unknown.
        footprint_mask: (h, w), footprints of objects; None where there are no masks.
        moving: (h, w), moving objects; None where there are no masks.
    """
    height, width = image.shape[:2]
    size = within((height, width))
    probability = nearest(ground_probability, size)
    visible = probability > GROUND_PROBABILITY
    undecided = ~visible & (probability >= NOT_GROUND_PROBABILITY)
    depth_m = nearest(ground_depth_m, size)
    obstacle = np.zeros(size, bool)
    if footprint_mask is not None:
        obstacle = nearest(drop_large_regions(footprint_mask), size)
    ground = np.where(undecided, UNKNOWN, UNSEEN).astype(np.uint8)
    ground[visible | (depth_m > 0)] = YES
    ground[obstacle] = NO
    depth_seen_m = None if visible_depth_m is None else nearest(visible_depth_m, size)
    if depth_seen_m is not None:  # ground that is seen is as far away as what is seen
        depth_m = np.where((depth_m <= 0) & visible, depth_seen_m, depth_m)
    return Sample(
        name,
        resized(image, size),
        intrinsics.scaled((height, width), size),
        np.select([visible, undecided], [YES, UNKNOWN], NO).astype(np.uint8),
        ground,
        None if depth_seen_m is None else depth_seen_m.astype(np.float16),
        np.where(ground == YES, depth_m, 0).astype(np.float16),
        # Moving objects hide ground that other frames may have seen. Visible ground and footprints
        # are labelled all the same.
        None if moving is None else (nearest(moving, size) & ~visible & ~obstacle).astype(np.uint8),
    )
