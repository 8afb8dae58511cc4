"""Starts the node on a camera's topics, and rviz2 with `rviz:=true`."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration

HERE = Path(__file__).resolve().parent
ARGUMENTS = {
    "image": "/camera/image_raw",
    "camera_info": "/camera/camera_info",
    "camera_height_m": ".nan",  # not known; give numbers with a point, as ROS asks: 1.0
    "pitch_deg": ".nan",
    "roll_deg": ".nan",
    "robot_height_m": "1.2",
    "ground_frame": "camera_footprint",
    "hidden": "cost",
    "rectified": "false",
    "rviz": "false",
}
TOPICS = ("image", "camera_info")


def generate_launch_description() -> LaunchDescription:
    """The description that `ros2 launch` asks for."""
    given = {name: LaunchConfiguration(name) for name in ARGUMENTS}
    options = []
    for name in [name for name in ARGUMENTS if name != "rviz"]:
        options += ["-r" if name in TOPICS else "-p", [name, ":=", given[name]]]
    return LaunchDescription(
        [
            *(DeclareLaunchArgument(name, default_value=ARGUMENTS[name]) for name in ARGUMENTS),
            ExecuteProcess(
                cmd=["python3", str(HERE / "footprints_node.py"), "--ros-args", *options],
                output="screen",
            ),
            ExecuteProcess(
                cmd=["rviz2", "-d", str(HERE / "footprints.rviz")],
                condition=IfCondition(given["rviz"]),
            ),
        ]
    )
