"""The messages that are written, as plain values: field by field those of ROS 2.

`footprints_edge.ros.fill` turns them into the messages of a library: rosbags, rclpy, rospy.
"""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Floats


@dataclass(frozen=True)
class Time:
    """Seconds and nanoseconds."""

    TYPE: ClassVar = "builtin_interfaces/msg/Time"
    sec: int
    nanosec: int


@dataclass(frozen=True)
class Header:
    """When something was true, and in which frame."""

    TYPE: ClassVar = "std_msgs/msg/Header"
    stamp: Time
    frame_id: str


@dataclass(frozen=True)
class Point:
    """A place, metres."""

    TYPE: ClassVar = "geometry_msgs/msg/Point"
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass(frozen=True)
class Vector3:
    """A translation, metres."""

    TYPE: ClassVar = "geometry_msgs/msg/Vector3"
    x: float
    y: float
    z: float


@dataclass(frozen=True)
class Quaternion:
    """A rotation; by default none."""

    TYPE: ClassVar = "geometry_msgs/msg/Quaternion"
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0


@dataclass(frozen=True)
class Pose:
    """A place and a rotation."""

    TYPE: ClassVar = "geometry_msgs/msg/Pose"
    position: Point
    orientation: Quaternion = field(default_factory=Quaternion)


@dataclass(frozen=True)
class MapMetaData:
    """The size and place of a grid: `origin` is the corner of its first cell."""

    TYPE: ClassVar = "nav_msgs/msg/MapMetaData"
    map_load_time: Time
    resolution: float
    width: int
    height: int
    origin: Pose


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """`data` is int8 (height * width,), by rows of constant y: 0 free, 100 occupied, -1 unknown."""

    TYPE: ClassVar = "nav_msgs/msg/OccupancyGrid"
    header: Header
    info: MapMetaData
    data: NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class LaserScan:
    """`ranges` by bearing, anticlockwise; by REP 117 infinite is clear, and NaN not in view."""

    TYPE: ClassVar = "sensor_msgs/msg/LaserScan"
    header: Header
    angle_min: float
    angle_max: float
    angle_increment: float
    time_increment: float
    scan_time: float
    range_min: float
    range_max: float
    ranges: Floats
    intensities: Floats


@dataclass(frozen=True)
class PointField:
    """A field of a point."""

    TYPE: ClassVar = "sensor_msgs/msg/PointField"
    name: str
    offset: int
    datatype: int
    count: int = 1


@dataclass(frozen=True, eq=False)
class PointCloud2:
    """`data` is uint8 (width * point_step,)."""

    TYPE: ClassVar = "sensor_msgs/msg/PointCloud2"
    header: Header
    height: int
    width: int
    fields: tuple[PointField, ...]
    is_bigendian: bool
    point_step: int
    row_step: int
    data: NDArray[np.uint8]
    is_dense: bool


@dataclass(frozen=True, eq=False)
class CompressedImage:
    """`data` is uint8 (N,), an encoded picture."""

    TYPE: ClassVar = "sensor_msgs/msg/CompressedImage"
    header: Header
    format: str
    data: NDArray[np.uint8]


@dataclass(frozen=True)
class Transform:
    """Takes points of the child frame to the parent frame."""

    TYPE: ClassVar = "geometry_msgs/msg/Transform"
    translation: Vector3
    rotation: Quaternion


@dataclass(frozen=True)
class TransformStamped:
    """The place of the child frame in the header's frame."""

    TYPE: ClassVar = "geometry_msgs/msg/TransformStamped"
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass(frozen=True)
class TFMessage:
    """What is published on /tf and /tf_static."""

    TYPE: ClassVar = "tf2_msgs/msg/TFMessage"
    transforms: tuple[TransformStamped, ...]
