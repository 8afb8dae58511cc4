"""Ranges by bearing, as a laser scanner at the camera's place on the ground would report them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Floats
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.navigation.obstacles import find_obstacles

_MEASURED = (
    (1.00, 0.55),
    (1.52, 0.57),
    (1.94, 0.64),
    (2.51, 0.60),
    (3.19, 0.60),
    (4.31, 0.79),
    (6.69, 0.67),
)
"""Range, metres, and the share of such ranges that lie within a quarter of the true distance, by
`fp-bench obstacles --every 8` on synthetic scenes: places unlike them are worse."""


@dataclass(frozen=True, eq=False)
class RangeScan:
    """The distance to the nearest obstacle by bearing, as in ROS's `sensor_msgs/LaserScan`.

    Attributes:
        bearings_deg: float64 (B,), degrees from straight ahead, left positive (REP-103).
        ranges_m: float32 (B,), metres from the point below the camera; infinite where no obstacle
            is seen, NaN where the picture does not show the bearing.
        confidence: float32 (B,), share of such ranges of the bundled model that lie within a
            quarter of the true one; 0 where there is no range.
    """

    bearings_deg: NDArray[np.float64]
    ranges_m: Floats
    confidence: Floats


def scan(
    prediction: GroundMaps,
    bearings_deg: NDArray[np.floating] | float,
    robot_height_m: float | None = None,
) -> RangeScan:
    """The scan of a prediction; see `Prediction.scan`."""
    bearings = np.atleast_1d(np.asarray(bearings_deg, np.float64))
    ranges_m = find_obstacles(prediction, robot_height_m).nearest_m(bearings)
    at_m, share = np.transpose(_MEASURED)
    finite = np.isfinite(ranges_m)
    confidence = np.interp(np.where(finite, ranges_m, 1), at_m, share) * finite
    return RangeScan(bearings, ranges_m, confidence.astype(np.float32))
