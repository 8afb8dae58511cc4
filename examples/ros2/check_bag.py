"""Writes a bag of pictures, runs `fp-infer` on it, and compares what comes out with the interface.

    python examples/ros2/check_bag.py --frames 300
    python examples/ros2/check_bag.py --frames 300 --ros 1

Each picture is a part of `examples/office.jpg` that wanders. Stamps are compared, and grids with
those of `Model.predict`, as two libraries read them: rosbags, and mcap-ros2-support or ROS 1's own
rosbag (Debian's `python3-rosbag` and `python3-nav-msgs`).
"""

import argparse
import os
import pickle
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from mcap_ros2.reader import read_ros2_messages
from PIL import Image
from rosbags import rosbag1, rosbag2
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin
from rosbags.typesys import Stores, get_typestore

import footprints_edge as fp
from footprints_edge.ros.ground_messages import TOPICS, grid_message
from footprints_edge.ros.messages import Header, Time

OFFICE = Path(__file__).resolve().parents[1] / "office.jpg"
SIZE = (320, 512)
CAMERA = fp.Intrinsics(495.6, 495.5, 255.5, 159.5)
TYPES_OF = {1: Stores.ROS1_NOETIC, 2: Stores.ROS2_HUMBLE}
DEBIAN = """
import pickle, rosbag, sys
read = rosbag.Bag(sys.argv[1]).read_messages([sys.argv[2]])
grids = [(m.header.stamp.to_nsec(), bytes(v & 255 for v in m.data)) for _, m, _ in read]
pickle.dump(grids, sys.stdout.buffer)
"""


def picture(index: int) -> np.ndarray:
    """uint8 (320, 512, 3): a part of the office."""
    office = np.asarray(Image.open(OFFICE).convert("RGB"))
    height, width = SIZE
    top = round((office.shape[0] - height) * (0.5 + 0.5 * np.sin(index / 40)))
    left = round((office.shape[1] - width) * (0.5 + 0.5 * np.cos(index / 23)))
    return np.ascontiguousarray(office[top : top + height, left : left + width])


def stamp_ns(index: int) -> int:
    """Of a picture: 30 a second, unevenly."""
    return 1_700_000_000_000_000_000 + index * 33_333_333 + index % 7 * 1001


def write_bag(folder: Path, frames: int, ros: int) -> Path:
    """A bag with a camera's pictures and its `CameraInfo`."""
    store = get_typestore(TYPES_OF[ros])
    types = store.types
    image_type, info_type = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
    to_bytes = store.serialize_ros1 if ros == 1 else store.serialize_cdr
    roi = types["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
    lens = np.zeros(5), CAMERA.matrix.ravel(), np.eye(3).ravel(), np.zeros(12)
    path = folder / ("drive.bag" if ros == 1 else "drive")
    mcap = {"version": 8, "storage_plugin": StoragePlugin.MCAP}
    with rosbag1.Writer(path) if ros == 1 else rosbag2.Writer(path, **mcap) as writer:
        images = writer.add_connection("/camera/image_raw", image_type, typestore=store)
        infos = writer.add_connection("/camera/camera_info", info_type, typestore=store)
        for index in range(frames):
            at_ns = stamp_ns(index)
            time = types["builtin_interfaces/msg/Time"](*divmod(at_ns, 10**9))
            numbered = (index,) if ros == 1 else ()
            header = types["std_msgs/msg/Header"](*numbered, time, "camera_optical_frame")
            pixels = picture(index).ravel()
            image = types[image_type](header, *SIZE, "rgb8", 0, 3 * SIZE[1], pixels)
            info = types[info_type](header, *SIZE, "plumb_bob", *lens, 0, 0, roi)
            writer.write(images, at_ns, to_bytes(image, image_type))
            writer.write(infos, at_ns, to_bytes(info, info_type))
    return path


def grids_by_rosbags(path: Path) -> dict[int, bytes]:
    """The cells of a bag's grids by their stamps, nanoseconds."""
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        return dict(
            as_plain(reader.deserialize(raw, connection.msgtype))
            for connection, _, raw in reader.messages()
            if connection.topic == TOPICS["grid"]
        )


def grids_by_another(path: Path, ros: int) -> dict[int, bytes]:
    """The same by another library."""
    if ros == 1:
        command = ["/usr/bin/python3", "-c", DEBIAN, str(path), TOPICS["grid"]]
        outside = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        read = subprocess.run(command, env=outside, check=True, stdout=subprocess.PIPE)
        return dict(pickle.loads(read.stdout))
    messages = read_ros2_messages(str(path), topics=[TOPICS["grid"]])
    return dict(as_plain(each.ros_msg) for each in messages)


def as_plain(grid: Any) -> tuple[int, bytes]:  # noqa: ANN401 - a message of either library
    """Stamp, nanoseconds, and cells of a grid."""
    stamp = grid.header.stamp
    return stamp.sec * 10**9 + stamp.nanosec, np.array(grid.data, np.int8).tobytes()


def main() -> None:
    """Prints what was compared; ends with 1 if anything differs."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--ros", type=int, choices=(1, 2), default=2)
    given = parser.parse_args()
    model = fp.load(threads=1)
    wanted = {}
    for index in range(given.frames):
        with suppress(fp.GroundPlaneError):
            grid = model.predict(picture(index), intrinsics=CAMERA).top_down()
            time = Time(*divmod(stamp_ns(index), 10**9))
            wanted[stamp_ns(index)] = grid_message(grid, Header(time, "")).data.tobytes()
    with TemporaryDirectory() as folder:
        source = write_bag(Path(folder), given.frames, given.ros)
        out = Path(folder, "out.bag" if given.ros == 1 else "out.mcap")
        command = [sys.executable, "-m", "footprints_edge", source, "-o", out, "--format", "grid"]
        subprocess.run([*map(str, command)], check=True)
        found = grids_by_rosbags(out), grids_by_another(out, given.ros)
    differing = sum(
        each.get(at_ns) != wanted.get(at_ns) for each in found for at_ns in {*each, *wanted}
    )
    sys.stdout.write(
        f"ROS {given.ros}, {given.frames} pictures: {len(found[0])} and {len(found[1])} grids, "
        f"{given.frames - len(wanted)} without a ground plane, {differing} that differ in stamp or "
        "cells\n"
    )
    raise SystemExit(differing > 0)


if __name__ == "__main__":
    main()
