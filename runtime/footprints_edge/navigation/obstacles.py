"""The one rule for obstacles: what is seen between a step and the robot's height above the ground.

Grids, scans, paths and pictures all follow it. A surface that is seen is an obstacle where it

- is higher above the ground plane than `STEP_HEIGHT_M` and lower than the robot, and
- is not visible ground. Ground that is seen far above the plane is none: table tops look like
  floors, so there the depth decides.

The depth is a network's. So its scale is taken from the visible ground, whose distance the plane
knows better. Pixels are counted by bearing and range, in bins that grow with the range as the
depth's error does, and a bin is occupied if enough surface is seen in it.
"""

import math
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Floats, Mask
from footprints_edge.geometry.obstacle_heights import STEP_HEIGHT_M, check_robot_height
from footprints_edge.maps.ground_maps import GroundMaps

BEARING_DEG = 1.0
"""Width of a bin."""

_NEAREST_M, _FARTHEST_M = 0.2, 50.0
_RANGE_STEP = 0.02
"""Length of a bin, as a share of its range."""

_WINDOW = 6
"""A bin is judged together with the bins behind it: 12 % of the range, about the depth's error. So
a surface that spreads over some bins begins at the nearest."""

_LEAST_SEEN_M = 0.01
"""Height of the surface seen in a window, over the width of a bin, that makes an obstacle."""

_LEAST_PX = 3

_RAISED = 0.35
"""Visible ground higher than this share of the camera's height is not ground. A smaller share puts
obstacles on open floors, where the depth is a quarter wrong."""

_STEEPEST = 0.04
"""Change of the logarithm of depth from pixel to pixel along a row. Where it is steeper, the depth
runs from one surface to another, and nothing stands there."""

_SCALED_BY_PX = 100
"""Pixels of visible ground that are needed to take the depth's scale from them."""

_RANGES = math.ceil(math.log(_FARTHEST_M / _NEAREST_M) / _RANGE_STEP)
_BEARINGS = round(180 / BEARING_DEG) + 1


@dataclass(frozen=True, eq=False)
class Obstacles:
    """What stands around the camera, by bearing and range, on the ground plane.

    Bearings are degrees from straight ahead, left positive (REP-103), from -90 to 90. Ranges are
    metres from the point below the camera.

    Attributes:
        occupied: bool (bearings, ranges).
        in_view: bool (bearings,), bearings that the picture shows.
        raised: bool (h, w), pixels of visible ground that are too high to be ground.
    """

    occupied: Mask
    in_view: Mask
    raised: Mask

    def covers(self, places_m: NDArray[np.floating], bins: NDArray[np.intp], cell_m: float) -> Mask:
        """Whether places are occupied.

        Args:
            places_m: (rows, columns, 2): x forward and y left, metres: the centres of square cells.
            bins: `bins_of` them.
            cell_m: Side of a cell, metres.

        Returns:
            bool (rows, columns). A cell is occupied if its centre lies in an occupied bin, or the
            centre of an occupied bin in it: near the camera bins are smaller than cells.
        """
        found = np.append(self.occupied, False).take(bins)
        angles, ranges_m = _centres()
        bearing, place = np.nonzero(self.occupied)
        angle, range_m = angles[bearing], ranges_m[place]
        x, y = range_m * np.cos(angle), range_m * np.sin(angle)
        row = np.floor((float(places_m[0, 0, 0]) - x) / cell_m + 0.5).astype(int)
        column = np.floor((places_m[0, 0, 1] - y) / cell_m + 0.5).astype(int)
        rows, columns = places_m.shape[:2]
        within = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        found[row[within], column[within]] = True
        return found

    def nearest_m(self, bearings_deg: NDArray[np.floating]) -> Floats:
        """The first occupied bin in each direction.

        Args:
            bearings_deg: (B,), degrees.

        Returns:
            Its range, float32 (B,), metres; infinite where nothing is seen, NaN outside the view.
        """
        given = np.asarray(bearings_deg, np.float64)
        row = np.rint(given / BEARING_DEG + (_BEARINGS - 1) / 2)
        visible = np.isfinite(row) & (row >= 0) & (row < _BEARINGS)
        row = np.where(visible, row, 0).astype(int)
        visible &= self.in_view[row]
        occupied = self.occupied[row]
        hit = occupied.any(axis=1) & visible
        range_m = np.where(hit, _centres()[1][occupied.argmax(axis=1)], np.inf)
        range_m[~visible] = np.nan
        return range_m.astype(np.float32)


def bins_of(places_m: NDArray[np.floating]) -> NDArray[np.intp]:
    """The bin of each place, for `Obstacles.covers`: the same for every picture.

    Args:
        places_m: (..., 2): x forward and y left, metres.

    Returns:
        (...,): index into the bins, row by row; the one after the last outside them.
    """
    bearing, place = _bins(np.arctan2(places_m[..., 1], places_m[..., 0]), _length(places_m))
    inside = (place >= 0) & (place < _RANGES) & (bearing >= 0) & (bearing < _BEARINGS)
    return np.where(inside, bearing * _RANGES + place, _BEARINGS * _RANGES)


def find_obstacles(prediction: GroundMaps, robot_height_m: float | None = None) -> Obstacles:
    """Applies the rule at the top of this page to a prediction.

    Args:
        prediction: A prediction with all four maps.
        robot_height_m: Height of the robot, metres; None means the prediction's.

    Raises:
        GroundPlaneError: If there is no ground plane.
        ValueError: If the height is not above a step.
    """
    robot_height_m = prediction.robot_height_m if robot_height_m is None else robot_height_m
    check_robot_height(robot_height_m)
    if robot_height_m != prediction.robot_height_m:
        return _found(prediction, robot_height_m)
    obstacles = _usual.get(prediction)
    if obstacles is None:
        obstacles = _usual[prediction] = _found(prediction, robot_height_m)
    return obstacles


_usual: "WeakKeyDictionary[GroundMaps, Obstacles]" = WeakKeyDictionary()
"""Obstacles for the prediction's own robot, found once: several outputs show them."""


def _found(prediction: GroundMaps, robot_height_m: float) -> Obstacles:
    plane, camera = prediction.ground_plane(), prediction.intrinsics
    height, width = prediction.map_size
    across = ((np.arange(width) - camera.cx) / camera.fx).astype(np.float32)
    along = ((np.arange(height) - camera.cy) / camera.fy).astype(np.float32)
    axes = plane.axes.astype(np.float32)
    rise = np.add.outer(along * axes[2, 1] + axes[2, 2], across * axes[2, 0])
    visible = prediction.visible_ground
    depth_m = _scaled(prediction.visible_depth_m, rise, visible, plane.camera_height_m)
    above_m = np.multiply(depth_m, rise, out=rise)
    above_m += np.float32(plane.camera_height_m)
    raised = visible & (above_m > max(STEP_HEIGHT_M, _RAISED * plane.camera_height_m))
    obstacle = (above_m > STEP_HEIGHT_M) & (above_m < robot_height_m) & (~visible | raised)
    before, after = depth_m[:, :-2], depth_m[:, 2:]
    most = np.float32(math.exp(2 * _STEEPEST))
    obstacle[:, 1:-1] &= (after < most * before) & (before < most * after)
    pixels = np.flatnonzero(obstacle)
    row = pixels.astype(np.int32) // np.int32(width)
    forward, left = _on_ground(axes, across.take(pixels - row * width), along.take(row))
    depth_m = depth_m.take(pixels)
    range_m = depth_m * np.sqrt(forward * forward + left * left)
    bearing, place = _bins(np.arctan2(left, forward), range_m)
    inside = (place >= 0) & (place < _RANGES) & (bearing >= 0) & (bearing < _BEARINGS)
    index = bearing * _RANGES + place
    # a pixel is depth / f wide and high, a bin as wide as an arc
    seen_m = depth_m * depth_m / range_m
    seen_m *= np.float32(1 / (camera.fx * camera.fy * math.radians(BEARING_DEG)))
    if not inside.all():
        index, seen_m = index[inside], seen_m[inside]
    of_bin = {"minlength": _BEARINGS * _RANGES}
    count, surface_m = np.bincount(index, **of_bin), np.bincount(index, seen_m, **of_bin)
    hit = np.flatnonzero(count)
    end = np.searchsorted(hit, np.minimum(hit + _WINDOW, hit - hit % _RANGES + _RANGES))
    enough = _up_to(end, count[hit]) >= _LEAST_PX
    enough &= _up_to(end, surface_m[hit]) >= _LEAST_SEEN_M
    occupied = np.zeros(_BEARINGS * _RANGES, bool)
    occupied[hit[enough]] = True
    in_view = _bearings_in_view(axes, across, along)
    return Obstacles(occupied.reshape(_BEARINGS, _RANGES), in_view, raised)


def _on_ground(axes: Floats, across: Floats, along: Floats) -> tuple[Floats, Floats]:
    """How far the rays of pixels reach forward and left for each metre of depth."""
    forward, left = (axis[0] * across + axis[1] * along + axis[2] for axis in axes[:2])
    return forward, left


def _bearings_in_view(axes: Floats, across: Floats, along: Floats) -> Mask:
    """Bool (bearings,): bearings of some pixel.

    Where all of the picture lies ahead, a bearing rises or falls along every line of pixels: it is
    least and most at corners. If pixels are much finer than bins, all bins between are in view.
    """
    corners = np.array([[x, y] for x in across[[0, -1]] for y in along[[0, -1]]], np.float32)
    forward, left = _on_ground(axes, corners[:, 0], corners[:, 1])
    finest = max(_step(across), _step(along)) < forward.min() * math.radians(BEARING_DEG) / 2
    if not finest:
        forward, left = _on_ground(axes, across[None, :], along[:, None])
    bearing, _ = _bins(np.arctan2(left, forward), np.ones(1))
    in_view = np.zeros(_BEARINGS, bool)
    if finest:
        in_view[max(0, bearing.min()) : max(0, bearing.max() + 1)] = True
    else:
        in_view[bearing[(bearing >= 0) & (bearing < _BEARINGS)]] = True
    return in_view


def _step(places: Floats) -> float:
    return float(places[1] - places[0]) if len(places) > 1 else 0.0


def _scaled(depth_m: Floats, rise: Floats, visible: Mask, camera_height_m: float) -> Floats:
    """The visible depth, scaled so that visible ground lies on the plane in the median."""
    ground = visible & (rise < np.float32(-1e-3))
    pixels = np.flatnonzero(ground)
    if len(pixels) < _SCALED_BY_PX:
        return depth_m
    too_far = np.median(depth_m.take(pixels) * -rise.take(pixels)) / camera_height_m
    return depth_m / np.float32(too_far)


def _bins(
    angle: NDArray[np.floating], range_m: NDArray[np.floating]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Indices of the bins of angles, radians, and ranges, metres; those out of range lie outside.

    The two need not have one shape.
    """
    bearing = np.rint(np.degrees(angle) / BEARING_DEG + (_BEARINGS - 1) / 2).astype(np.intp)
    place = np.log(np.maximum(range_m, 1e-3) / _NEAREST_M) / _RANGE_STEP
    return bearing, np.floor(np.minimum(place, _RANGES)).astype(np.intp)


def _centres() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Angles of the bins, radians, float64 (bearings,), and ranges, metres, float64 (ranges,)."""
    angle = np.radians((np.arange(_BEARINGS) - (_BEARINGS - 1) / 2) * BEARING_DEG)
    return angle, _NEAREST_M * np.exp((np.arange(_RANGES) + 0.5) * _RANGE_STEP)


def _up_to(end: NDArray[np.intp], values: NDArray[np.number]) -> NDArray[np.float64]:
    """Sums of the values (n,) from each place to `end` (n,), which is not included."""
    sums = np.zeros(len(values) + 1)
    np.cumsum(values, out=sums[1:])
    windows: NDArray[np.float64] = sums[end] - sums[:-1]
    return windows


def _length(places_m: NDArray[np.floating]) -> NDArray[np.float64]:
    length: NDArray[np.float64] = np.hypot(places_m[..., 0], places_m[..., 1])
    return length
