"""Snapping of the ground's depth to the ground plane, where it lies close to it."""

import numpy as np

from footprints_edge.errors import GroundPlaneError
from footprints_edge.maps.ground_maps import MapsT

_SNAP_BELOW, _KEEP_ABOVE = 0.4, 0.8
"""Bounds of a pixel's |ln(depth / plane depth)|. Up to the first, it counts as the network's error
and the pixel moves onto the plane; from the second on, as another surface. In between, both mix."""

_FARTHEST_M = 100.0
"""With a known pose all ground nearer than this lies on the plane; the rest, at the horizon, keeps
its depth."""


def flatten(prediction: MapsT) -> MapsT:
    """The same prediction with ground depth on the plane; see `Prediction.flattened`."""
    if prediction.laid_onto is not None:
        return prediction
    if not all(map(prediction.has, ("ground_probability", "unmasked_ground_depth_m"))):
        return prediction
    try:
        plane = prediction.ground_plane()
    except GroundPlaneError:
        return prediction
    inverse_depth = np.reciprocal(prediction.unmasked_ground_depth_m)
    plane_inverse_depth = plane.inverse_depth(prediction.intrinsics, prediction.map_size)
    if prediction.pose.everything:
        near = plane_inverse_depth > np.float32(1 / _FARTHEST_M)
        laid = np.where(near, plane_inverse_depth, inverse_depth)
        return prediction.with_maps(unmasked_ground_depth_m=np.reciprocal(laid), laid_onto=plane)
    above_horizon = plane_inverse_depth <= np.float32(1e-4)
    plane_inverse_depth[above_horizon] = 1
    # in one array from here on: a new one for each step would take longer than the arithmetic
    weight = plane_inverse_depth / inverse_depth
    np.log(weight, out=weight)
    if prediction.pose.anything:  # a known height corrects the scale of the depth
        weight -= np.median(weight[prediction.ground])
    np.abs(weight, out=weight)
    np.subtract(np.float32(_KEEP_ABOVE), weight, out=weight)
    weight *= np.float32(1 / (_KEEP_ABOVE - _SNAP_BELOW))
    weight.clip(0, 1, out=weight)
    weight[above_horizon] = 0
    plane_inverse_depth -= inverse_depth
    weight *= plane_inverse_depth
    weight += inverse_depth
    mixed = np.reciprocal(weight, out=weight)
    return prediction.with_maps(unmasked_ground_depth_m=mixed, laid_onto=plane)
