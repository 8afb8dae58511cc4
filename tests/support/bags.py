"""Small bags, written by rosbags: pictures whose number is their stamp."""

import numpy as np

SIZE = (48, 64)
"""(H, W) of the pictures."""

FRAME = "front_optical_frame"
START_NS = 1_700_000_000_123_456_789
STEP_NS = 100_000_007
K = (60.0, 0, 31.5, 0, 61.0, 23.5, 0, 0, 1.0)


def stamp_of(index):
    """(seconds, nanoseconds) of a picture's header."""
    return divmod(START_NS + index * STEP_NS, 10**9)


def picture(index, size=SIZE):
    """uint8 (H, W, 3): for the tiny model ground below the horizon, a part of it hidden, and above
    it a wall."""
    height, width = size
    below = np.arange(height)[:, None] - height // 2
    rgb = np.zeros((height, width, 3), np.uint8)
    rgb[height // 2 :, :, 1] = 230
    rgb[height // 2 + 6 : height // 2 + 12, 20:40, :2] = (230, 0)
    rgb[..., 2] = np.where(below > 0, 2 * below, 12)  # inverse depth of a plane
    rgb[0, 0] = index % 256
    return rgb


class Messages:
    """Messages of ROS 1 or ROS 2 from plain values."""

    def __init__(self, ros):
        from footprints_edge.ros.rosbags_library import message_types

        self.ros, self.store = ros, message_types(ros)

    def make(self, name, /, **fields):
        if name == "std_msgs/msg/Header" and self.ros == 1:
            fields["seq"] = 0
        return self.store.types[name](**fields)

    def header(self, index, frame=FRAME):
        sec, nanosec = stamp_of(index)
        stamp = self.make("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)

    def image(self, index, rgb=None, encoding="rgb8", step=None, **changed):
        pixels = picture(index) if rgb is None else rgb
        height, width = pixels.shape[:2]
        data = np.frombuffer(pixels.tobytes(), np.uint8)
        fields = {
            "header": self.header(index),
            "height": height,
            "width": width,
            "encoding": encoding,
            "is_bigendian": 0,
            "step": step or data.size // height,
            "data": data,
        }
        return self.make("sensor_msgs/msg/Image", **{**fields, **changed})

    def compressed(self, index, data, kind="jpeg"):
        return self.make(
            "sensor_msgs/msg/CompressedImage",
            header=self.header(index),
            format=kind,
            data=np.frombuffer(data, np.uint8),
        )

    def camera_info(self, index, k=K, d=(), model="plumb_bob", size=SIZE, p=(0.0,) * 12, **changed):
        roi = self.make(
            "sensor_msgs/msg/RegionOfInterest",
            x_offset=0,
            y_offset=0,
            height=0,
            width=0,
            do_rectify=False,
        )
        arrays = {"d": d, "k": k, "r": np.eye(3).ravel(), "p": p}
        arrays = {name: np.array(values, np.float64) for name, values in arrays.items()}
        if self.ros == 1:
            arrays = {name.upper(): values for name, values in arrays.items()}
        fields = {
            "header": self.header(index),
            "height": size[0],
            "width": size[1],
            "distortion_model": model,
            "binning_x": 0,
            "binning_y": 0,
            "roi": roi,
            **arrays,
        }
        return self.make("sensor_msgs/msg/CameraInfo", **{**fields, **changed})


def write_bag(path, items, ros=2):
    """Writes a bag.

    Args:
        path: A file `.bag` of ROS 1, or a folder of ROS 2: mcap if its name ends so, else sqlite3.
        items: (topic, nanoseconds, message) each; a message may be bytes beside its type.
        ros: 1 or 2.
    """
    from rosbags import rosbag1, rosbag2

    store = Messages(ros).store
    if ros == 1:
        writer = rosbag1.Writer(path)
    else:
        kind = "MCAP" if path.name.endswith("mcap") else "SQLITE3"
        writer = rosbag2.Writer(path, version=8, storage_plugin=rosbag2.StoragePlugin[kind])
    serialise = store.serialize_ros1 if ros == 1 else store.serialize_cdr
    connections = {}
    with writer:
        for topic, time_ns, message in items:
            raw, name = (
                message
                if isinstance(message, tuple)
                else (serialise(message, message.__msgtype__), message.__msgtype__)
            )
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=store)
            writer.write(connections[topic], time_ns, raw)
    return path


def mcap_file(folder, items):
    """The file of an mcap bag of these items."""
    bag = write_bag(folder / "drive_mcap", items)
    return (bag / "drive_mcap.mcap").rename(folder / "drive.mcap")


def drive(count=3, ros=2, image="/front/image_raw", info="/front/camera_info"):
    """The items of a drive: each picture with its camera."""
    messages = Messages(ros)
    for index in range(count):
        logged_ns = START_NS + index * STEP_NS + 5_000_000
        yield image, logged_ns, messages.image(index)
        if info:
            yield info, logged_ns + 1000, messages.camera_info(index)
