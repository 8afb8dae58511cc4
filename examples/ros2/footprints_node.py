"""A ROS 2 node: pictures of one camera in, the ground around it out.

ros2 launch ./footprints.launch.py image:=/camera/image_raw camera_info:=/camera/camera_info
"""

import math
from contextlib import suppress
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosidl_runtime_py.utilities import get_message
from sensor_msgs.msg import CameraInfo, Image

import footprints_edge as fp
from footprints_edge.geometry.obstacle_heights import ROBOT_HEIGHT_M
from footprints_edge.ros import messages
from footprints_edge.ros.camera_info import LatestCamera
from footprints_edge.ros.fill import fill, plain_array
from footprints_edge.ros.ground_messages import TOPICS, GroundOutput, ground_messages
from footprints_edge.ros.image_messages import picture_of

PUBLISHED = {
    "grid": messages.OccupancyGrid,
    "scan": messages.LaserScan,
    "points": messages.PointCloud2,
    "tf": messages.TFMessage,
    "tf_static": messages.TFMessage,
}
UNKNOWN = math.nan  # a parameter of ROS has a number


class Footprints(Node):
    """Finds the ground in the newest picture; older ones that wait are left out."""

    def __init__(self) -> None:
        super().__init__("footprints")
        value = {
            name: self.declare_parameter(name, default).value
            for name, default in {
                "camera_height_m": UNKNOWN,
                "pitch_deg": UNKNOWN,
                "roll_deg": UNKNOWN,
                "robot_height_m": ROBOT_HEIGHT_M,
                "ground_frame": "camera_footprint",
                "hidden": "cost",
                "rectified": False,
                "threads": 2,
            }.items()
        }
        known = ("camera_height_m", "pitch_deg", "roll_deg")
        self.given = {name: None if math.isnan(value[name]) else value[name] for name in known}
        self.given["robot_height_m"] = value["robot_height_m"]
        self.output = GroundOutput(tuple(PUBLISHED), value["ground_frame"], value["hidden"])
        self.model = fp.load(threads=value["threads"])
        self.camera = LatestCamera(rectified=value["rectified"])
        newest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.publisher = {
            key: self.create_publisher(
                get_message(kind.TYPE), TOPICS[key], latched if key == "tf_static" else 10
            )
            for key, kind in PUBLISHED.items()
        }
        self.create_subscription(CameraInfo, "camera_info", self.on_camera_info, newest)
        self.create_subscription(Image, "image", self.on_image, newest)

    def on_camera_info(self, info: CameraInfo) -> None:
        """Takes the camera for the pictures to come."""
        try:
            self.camera.read(info)
        except fp.FootprintsError as error:
            self.warn(f"camera_info: {error}")

    def on_image(self, image: Image) -> None:
        """Publishes the ground of a picture, with its stamp."""
        stamp = messages.Time(image.header.stamp.sec, image.header.stamp.nanosec)
        header = messages.Header(stamp, image.header.frame_id)
        if self.camera.camera is None:
            self.warn("no camera_info: the lens is assumed, and all metres depend on it")
        try:
            prediction = self.model.predict(
                picture_of(image), intrinsics=self.camera.camera, **self.given
            )
            for key, contents in ground_messages(prediction, header, self.output):
                self.publisher[key].publish(fill(contents, make, plain_array))
        except fp.FootprintsError as error:
            self.warn(str(error))

    def warn(self, text: str) -> None:
        """Says something every five seconds at most."""
        self.get_logger().warning(text, throttle_duration_sec=5.0)


def make(kind: str, /, **fields: Any) -> Any:  # noqa: ANN401 - any message
    """A message of rclpy."""
    return get_message(kind)(**fields)


def main() -> None:
    """Runs the node until Ctrl-C."""
    rclpy.init()
    with suppress(KeyboardInterrupt):
        rclpy.spin(Footprints())


if __name__ == "__main__":
    main()
