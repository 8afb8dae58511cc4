"""Writes a bag of pictures, runs `fp-infer` on it, and compares what comes out with the interface.

    python examples/ros2/check_bag.py --frames 300

Each picture is a part of `examples/office.jpg` that wanders. Stamps are compared, and grids with
those of `Model.predict`, as rosbags and as mcap-ros2-support read them.
"""

import argparse
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from mcap_ros2.reader import read_ros2_messages
from PIL import Image
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import footprints_edge as fp
from footprints_edge.ros.ground_messages import TOPICS, grid_message
from footprints_edge.ros.messages import Header, Time

OFFICE = Path(__file__).resolve().parents[1] / "office.jpg"
SIZE = (320, 512)
CAMERA = fp.Intrinsics(495.6, 495.5, 255.5, 159.5)
STORE = get_typestore(Stores.ROS2_HUMBLE)
TYPES = STORE.types


def picture(index: int) -> np.ndarray:
    """uint8 (320, 512, 3): a part of the office."""
    office = np.asarray(Image.open(OFFICE).convert("RGB"))
    height, width = SIZE
    top = round((office.shape[0] - height) * (0.5 + 0.5 * np.sin(index / 40)))
    left = round((office.shape[1] - width) * (0.5 + 0.5 * np.cos(index / 23)))
    return np.ascontiguousarray(office[top : top + height, left : left + width])


def stamp(index: int) -> tuple[int, int]:
    """Seconds and nanoseconds of a picture: 30 a second, unevenly."""
    return divmod(1_700_000_000_000_000_000 + index * 33_333_333 + index % 7 * 1001, 10**9)


def header(index: int) -> Any:  # noqa: ANN401 - of rosbags
    """The header of a picture and of its camera."""
    time = TYPES["builtin_interfaces/msg/Time"](*stamp(index))
    return TYPES["std_msgs/msg/Header"](time, "camera_optical_frame")


def write_bag(folder: Path, frames: int) -> Path:
    """A bag of ROS 2 with a camera's pictures and its `CameraInfo`."""
    image_type, info_type = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
    none = np.zeros(5), np.eye(3).ravel(), np.zeros(12)
    roi = TYPES["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
    with Writer(folder / "drive", version=8, storage_plugin=StoragePlugin.MCAP) as writer:
        images = writer.add_connection("/camera/image_raw", image_type, typestore=STORE)
        infos = writer.add_connection("/camera/camera_info", info_type, typestore=STORE)
        for index in range(frames):
            sec, nanosec = stamp(index)
            at_ns = sec * 10**9 + nanosec
            pixels = picture(index).ravel()
            image = TYPES[image_type](header(index), *SIZE, "rgb8", 0, 3 * SIZE[1], pixels)
            d, r, p = none
            K = CAMERA.matrix.ravel()
            info = TYPES[info_type](header(index), *SIZE, "plumb_bob", d, K, r, p, 0, 0, roi)
            writer.write(images, at_ns, STORE.serialize_cdr(image, image_type))
            writer.write(infos, at_ns, STORE.serialize_cdr(info, info_type))
    return folder / "drive"


def grids_by_rosbags(path: Path) -> Iterator[Any]:
    """The grids of a bag."""
    with AnyReader([path]) as reader:
        for connection, _, raw in reader.messages():
            if connection.topic == TOPICS["grid"]:
                yield reader.deserialize(raw, connection.msgtype)


def grids_by_mcap(path: Path) -> Iterator[Any]:
    """The same by another library."""
    for each in read_ros2_messages(str(path), topics=[TOPICS["grid"]]):
        yield each.ros_msg


def main() -> None:
    """Prints what was compared; ends with 1 if anything differs."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--frames", type=int, default=300)
    frames = parser.parse_args().frames
    model = fp.load(threads=1)
    differing = 0
    with TemporaryDirectory() as folder:
        source, out = write_bag(Path(folder), frames), Path(folder, "out.mcap")
        command = [sys.executable, "-m", "footprints_edge", source, "-o", out]
        subprocess.run([*map(str, command), "--format", "grid"], check=True)
        both = zip(grids_by_rosbags(out), grids_by_mcap(out), strict=True)
        found = {(a.header.stamp.sec, a.header.stamp.nanosec): (a, b) for a, b in both}
        without = 0
        for index in range(frames):
            try:
                grid = model.predict(picture(index), intrinsics=CAMERA).top_down()
            except fp.GroundPlaneError:
                without += 1
                differing += stamp(index) in found
                continue
            wanted = grid_message(grid, Header(Time(*stamp(index)), "camera_footprint"))
            for got in found.get(stamp(index), (None,)):
                differing += got is None or not (
                    (got.header.stamp.sec, got.header.stamp.nanosec) == stamp(index)
                    and np.array_equal(np.array(got.data, np.int8), wanted.data)
                )
    sys.stdout.write(
        f"{frames} pictures: {len(found)} grids, {without} without a ground plane, "
        f"{differing} that differ in stamp or cells\n"
    )
    raise SystemExit(differing > 0)


if __name__ == "__main__":
    main()
