"""Snapping of the ground's depth to the ground plane, where it lies close to it."""

import numpy as np

from footprints_edge.errors import GroundPlaneError
from footprints_edge.foundation.types import Floats, Mask
from footprints_edge.maps.ground_maps import MapsT

_SNAP_BELOW, _KEEP_ABOVE = 0.4, 0.8
"""Bounds of a pixel's |ln(depth / plane depth)|. Up to the first, it counts as the network's error
and the pixel moves onto the plane; from the second on, as another surface. In between, both mix."""

_FARTHEST_M = 100.0
"""With a known pose all ground nearer than this lies on the plane; the rest, at the horizon, keeps
its depth."""

_HORIZON = np.float32(1e-4)
"""Inverse depth of the plane, 1 / metres, up to which a pixel counts as above the horizon."""

_UNLIKE_ANY = np.float32(1e-30)
"""Stands for the plane's inverse depth above the horizon: far from every depth of a network."""

_BAND_PX = 64
"""Rows laid flat at a time, to fit the processor's cache."""


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
    depth_m = prediction.unmasked_ground_depth_m
    plane_inverse_depth = plane.inverse_depth(prediction.intrinsics, prediction.map_size)
    if prediction.pose.everything:
        near = plane_inverse_depth > np.float32(1 / _FARTHEST_M)
        inverse_depth = np.where(near, plane_inverse_depth, np.reciprocal(depth_m))
        return prediction.with_maps(
            unmasked_ground_depth_m=np.reciprocal(inverse_depth), laid_onto=plane
        )
    height_error = 0.0
    if prediction.pose.anything:  # a known height corrects the scale of the depth
        height_error = _median_deviation(plane_inverse_depth, depth_m, prediction.ground)
    laid = depth_m.copy()
    below = _rows_below_horizon(plane_inverse_depth)
    for top in range(below.start, below.stop, _BAND_PX):
        rows = slice(top, min(below.stop, top + _BAND_PX))
        laid[rows] = _mixed(plane_inverse_depth[rows], depth_m[rows], height_error)
    return prediction.with_maps(unmasked_ground_depth_m=laid, laid_onto=plane)


def _rows_below_horizon(plane_inverse_depth: Floats) -> slice:
    """The rows that reach below the horizon, which is straight: where one of their ends does."""
    ends = plane_inverse_depth[:, [0, -1]]
    found = np.flatnonzero((ends > _HORIZON).any(axis=1))
    return slice(int(found[0]), int(found[-1]) + 1) if found.size else slice(0, 0)


def _median_deviation(plane_inverse_depth: Floats, depth_m: Floats, ground: Mask) -> float:
    """The median of ln(depth / plane's depth) over the ground."""
    plane_inverse_depth = plane_inverse_depth[ground]
    below = plane_inverse_depth > _HORIZON
    return float(np.median(np.log(np.where(below, plane_inverse_depth, 1) * depth_m[ground])))


def _mixed(plane_inverse_depth: Floats, depth_m: Floats, height_error: float) -> Floats:
    """Depths between the network's and the plane's, whose inverse this overwrites."""
    inverse_depth = np.reciprocal(depth_m)
    above_horizon = plane_inverse_depth <= _HORIZON
    if above_horizon.any():
        plane_inverse_depth[above_horizon] = _UNLIKE_ANY
    # in two arrays from here on: a new one for each step would take longer than the arithmetic
    weight = plane_inverse_depth / inverse_depth
    np.log(weight, out=weight)
    if height_error:
        weight -= np.float32(height_error)
    np.abs(weight, out=weight)
    np.subtract(np.float32(_KEEP_ABOVE), weight, out=weight)
    weight *= np.float32(1 / (_KEEP_ABOVE - _SNAP_BELOW))
    weight.clip(0, 1, out=weight)
    plane_inverse_depth -= inverse_depth
    weight *= plane_inverse_depth
    weight += inverse_depth
    return np.reciprocal(weight, out=weight)
