"""A prediction as messages: the one place where ROS's axes, frames and values are decided.

Ground coordinates are those of `GroundPlane` and of REP-103: x forward, y left, z up, from the
point on the ground below the camera. They are a frame of their own, `ground_frame`, whose place is
published as a child of the camera's optical frame (x right, y down, z forward), so that it fits
into any robot's tree.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import GroundPlaneError
from footprints_edge.geometry.camera import backproject
from footprints_edge.geometry.ground_plane import GroundPlane
from footprints_edge.inputs.preprocessing import enough_for, preprocess
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.navigation import occupancy_grid, range_scan
from footprints_edge.outputs.ply import HIDDEN_GROUND_RGB
from footprints_edge.ros.messages import (
    Header,
    LaserScan,
    MapMetaData,
    OccupancyGrid,
    Point,
    PointCloud2,
    PointField,
    Pose,
    Quaternion,
    TFMessage,
    Transform,
    TransformStamped,
    Vector3,
)

OPTICAL_FRAME = "camera_optical_frame"
"""The frame of pictures whose header names none."""

GROUND_FRAME = "camera_footprint"
"""Default name of the ground's frame, as `base_footprint` is that of a robot."""

TOPICS = {
    "grid": "/footprints/occupancy_grid",
    "scan": "/footprints/scan",
    "points": "/footprints/points",
    "overlay": "/footprints/overlay/compressed",
    "tf": "/tf",
    "tf_static": "/tf_static",
}
"""Where the messages of `ground_messages` are published."""

HIDDEN_COSTS: dict[occupancy_grid.HiddenAs, int] = {"cost": 50, "unknown": -1, "free": 0}
"""Values of hidden ground: those that a map server makes of `OccupancyGrid.save`."""

_SCAN_RANGE_M = (0.2, 50.0)
"""Nearest and farthest range that a scan can have."""

_EVERY = 2
"""Points are every second one along and across: their distance is that of a costmap's cells."""

_UINT8, _FLOAT32 = 2, 7  # of sensor_msgs/PointField
_POINT = np.dtype(
    {
        "names": ["x", "y", "z", "rgb", "layer"],
        "formats": ["<f4", "<f4", "<f4", "<u4", "u1"],
        "offsets": [0, 4, 8, 12, 16],
        "itemsize": 20,
    }
)


@dataclass(frozen=True)
class GroundOutput:
    """What is written of each prediction.

    Attributes:
        kinds: Any of `grid`, `scan`, `points` and `overlay`.
        ground_frame: Name of the ground's frame.
        hidden: What hidden ground becomes in the grid: a `cost` half way between free and occupied,
            `unknown`, or `free`.
    """

    kinds: tuple[str, ...] = ("grid", "scan", "points", "overlay")
    ground_frame: str = GROUND_FRAME
    hidden: occupancy_grid.HiddenAs = "cost"


def ground_messages(
    prediction: GroundMaps, header: Header, output: GroundOutput = GroundOutput()
) -> Iterator[tuple[str, TFMessage | OccupancyGrid | LaserScan | PointCloud2]]:
    """The messages of a prediction, with their keys in `TOPICS`.

    Without a ground plane there is no grid, no scan and no transform: nothing is known then, which
    is not the same as nothing being there.

    Args:
        prediction: The prediction.
        header: The picture's own header.
        output: What is wanted; overlays are drawn by the caller.
    """
    header = Header(header.stamp, header.frame_id or OPTICAL_FRAME)
    on_ground = Header(header.stamp, output.ground_frame)
    try:
        plane = prediction.ground_plane()
    except GroundPlaneError:
        plane = None
    if plane is not None:
        key = "tf_static" if prediction.pose.everything else "tf"
        yield key, ground_transform(plane, header, output.ground_frame)
        if "grid" in output.kinds:
            grid = occupancy_grid.make_occupancy_grid(prediction)
            yield "grid", grid_message(grid, on_ground, output.hidden)
        if "scan" in output.kinds:
            ranges = range_scan.scan(prediction, np.arange(-90.0, 91.0))
            yield "scan", scan_message(ranges, on_ground)
    if "points" in output.kinds:
        yield "points", points_message(prediction, header)


def ground_transform(plane: GroundPlane, header: Header, ground_frame: str) -> TFMessage:
    """The ground's frame as a child of the optical frame.

    Args:
        plane: The ground plane.
        header: The picture's header: its frame is the optical frame.
        ground_frame: Name of the ground's frame.
    """
    x, y, z = (float(part) for part in -plane.camera_height_m * plane.up)
    rotation = _quaternion(plane.axes.T)  # its columns are the ground's axes in the camera's
    transform = Transform(Vector3(x, y, z), rotation)
    return TFMessage((TransformStamped(header, ground_frame, transform),))


def grid_message(
    grid: occupancy_grid.OccupancyGrid, header: Header, hidden: occupancy_grid.HiddenAs = "cost"
) -> OccupancyGrid:
    """The grid as `nav_msgs/OccupancyGrid`, in the ground's frame.

    ROS's rows run along x, from the lowest x and y on; those of `cells` from far to near.

    Args:
        grid: The grid.
        header: Its header.
        hidden: As for `GroundOutput`.
    """
    rows, columns = grid.cells.shape
    values = np.zeros(4, np.int8)
    values[occupancy_grid.UNKNOWN] = -1
    values[occupancy_grid.OCCUPIED] = 100
    values[occupancy_grid.HIDDEN] = HIDDEN_COSTS[hidden]
    corner = Point(0.0, -columns / 2 * grid.cell_m, 0.0)
    info = MapMetaData(header.stamp, grid.cell_m, rows, columns, Pose(corner))
    return OccupancyGrid(header, info, values[grid.cells[::-1, ::-1].T].ravel())


def scan_message(ranges: range_scan.RangeScan, header: Header) -> LaserScan:
    """The scan as `sensor_msgs/LaserScan`, in the ground's frame; intensities are the confidence.

    Args:
        ranges: A scan of evenly spaced bearings, from right to left.
        header: Its header.
    """
    first, last = (math.radians(ranges.bearings_deg[at]) for at in (0, -1))
    nearest_m, farthest_m = _SCAN_RANGE_M
    return LaserScan(
        header,
        angle_min=first,
        angle_max=last,
        angle_increment=(last - first) / (len(ranges.bearings_deg) - 1),
        time_increment=0.0,
        scan_time=0.0,
        range_min=nearest_m,
        range_max=farthest_m,
        ranges=ranges.ranges_m,
        intensities=ranges.confidence,
    )


def points_message(prediction: GroundMaps, header: Header) -> PointCloud2:
    """Visible surfaces and hidden ground as `sensor_msgs/PointCloud2`, in the optical frame.

    The points of the `ply` output, every second one along and across. Field `rgb` is packed as PCL
    does; `layer` is 0 for visible surfaces and 1 for hidden ground, which is magenta.

    Args:
        prediction: The prediction.
        header: The picture's header.
    """
    some = np.s_[::_EVERY, ::_EVERY]
    seen = backproject(prediction.visible_depth_m, prediction.intrinsics)[some]
    ground = backproject(prediction.unmasked_ground_depth_m, prediction.intrinsics)[some]
    ground = ground[prediction.hidden_ground[some]]
    picture = prediction.picture.at_least(enough_for(prediction.map_size))
    colours = preprocess(picture, prediction.map_size)[0][some].reshape(-1, 3).astype(np.uint32)
    points = np.zeros(len(colours) + len(ground), _POINT)
    for axis, name in enumerate("xyz"):
        points[name] = np.append(seen[..., axis], ground[..., axis])
    red, green, blue = HIDDEN_GROUND_RGB
    points["rgb"] = red << 16 | green << 8 | blue
    points["rgb"][: len(colours)] = colours @ np.array([1 << 16, 1 << 8, 1], np.uint32)
    points["layer"][len(colours) :] = 1
    offset_of: Mapping[str, Any] = _POINT.fields or {}
    fields = tuple(
        PointField(name, offset_of[name][1], _UINT8 if name == "layer" else _FLOAT32)
        for name in offset_of
    )
    data = np.frombuffer(points.tobytes(), np.uint8)
    step = _POINT.itemsize
    return PointCloud2(header, 1, len(points), fields, False, step, data.size, data, True)


def _quaternion(rotation: NDArray[np.float64]) -> Quaternion:
    """The unit quaternion of a rotation matrix (3, 3): the eigenvector of Bar-Itzhack (2000)."""
    r = rotation
    symmetric = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
            [r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
            [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], np.trace(r)],
        ]
    )
    x, y, z, w = (float(part) for part in np.linalg.eigh(symmetric)[1][:, -1])
    return Quaternion(x, y, z, w) if w >= 0 else Quaternion(-x, -y, -z, -w)
