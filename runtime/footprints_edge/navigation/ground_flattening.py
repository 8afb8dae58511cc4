"""Ground depth laid onto the ground's plane, where it lies near to it."""

import numpy as np

from footprints_edge.errors import GroundPlaneError
from footprints_edge.maps.ground_maps import MapsT

FLAT = 0.15
"""Where the median of |ln(depth / depth of the plane)| over the ground is less, it is flat."""

_WHOLLY, _NOT_AT_ALL = 0.4, 0.8
"""Up to the first, a pixel's |ln(depth / depth of the plane)| is taken for the network's error and
the pixel laid onto the plane; from the second on, for another surface."""


def flatten(prediction: MapsT) -> MapsT:
    """The same with ground depth on the plane; see `Prediction.flattened`."""
    if prediction.laid_onto is not None:
        return prediction
    if not all(map(prediction.has, ("ground_probability", "unmasked_ground_depth_m"))):
        return prediction
    try:
        plane = prediction.ground_plane()
    except GroundPlaneError:
        return prediction
    inverse_depth = np.reciprocal(prediction.unmasked_ground_depth_m)
    flat_inverse_depth = plane.inverse_depth(prediction.intrinsics, prediction.map_size)
    below = flat_inverse_depth > np.float32(1e-4)
    away = np.abs(np.log(np.where(below, flat_inverse_depth, 1) / inverse_depth))
    away[~below] = np.inf
    if np.median(away[prediction.ground]) > FLAT:
        return prediction
    share = np.clip((_NOT_AT_ALL - away) * np.float32(1 / (_NOT_AT_ALL - _WHOLLY)), 0, 1)
    mixed = inverse_depth + share * (flat_inverse_depth - inverse_depth)
    return prediction.with_maps(unmasked_ground_depth_m=np.reciprocal(mixed), laid_onto=plane)
