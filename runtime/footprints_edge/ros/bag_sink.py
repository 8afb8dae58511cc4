"""The ground as a bag: of ROS 2 (`.mcap`) or ROS 1 (`.bag`), by the suffix."""

from pathlib import Path
from shutil import rmtree
from typing import Any

import numpy as np

from footprints_edge.errors import BagError
from footprints_edge.foundation.opencv import opencv
from footprints_edge.foundation.parts import new_part
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.ros.bag_names import partial_bag
from footprints_edge.ros.bag_source import BagFrame
from footprints_edge.ros.fill import fill
from footprints_edge.ros.ground_messages import TOPICS, GroundOutput, ground_messages
from footprints_edge.ros.messages import CompressedImage, Header
from footprints_edge.ros.rosbags_library import message_types, rosbags
from footprints_edge.video.capture import VideoFrame
from footprints_edge.video.overlay import VideoOverlay
from footprints_edge.video.sinks import FileSink

_RECORDED_AS = 8
"""Version of the bag's metadata: that of ROS 2 Iron, which later ones read."""


class BagSink(FileSink):
    """Writes the messages of each prediction with the stamp, and at the time, of its picture.

    Attributes:
        without_ground: Number of pictures without a ground plane, and so without a grid.
    """

    def __init__(self, path: Path, output: GroundOutput, *, bev: bool = False) -> None:
        """Creates the bag.

        Args:
            path: The whole bag, `.mcap` or `.bag`.
            output: What is written of each prediction.
            bev: Whether overlays have a bird's-eye view beside them.

        Raises:
            BagError: If it cannot be created, or rosbags is missing.
        """
        super().__init__(path, endless=False, growing=partial_bag(path))
        self.without_ground = 0
        self._output = output
        self._overlay = VideoOverlay(bev=bev)
        self._static: Any = None
        self._messages = 0
        bag = _Ros1Bag if path.suffix.lower() == ".bag" else _McapBag
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._bag = bag(self._growing)
        except OSError as error:
            raise BagError(f"cannot write {path}: {error.strerror or error}") from error

    def write(self, frame: VideoFrame, prediction: GroundMaps) -> None:
        """Writes the messages of one picture."""
        assert isinstance(frame, BagFrame)
        on_ground = False
        for key, contents in ground_messages(prediction, frame.header, self._output):
            on_ground |= key in {"tf", "tf_static"}
            if key == "tf_static":
                if contents_equal(self._static, contents):
                    continue
                self._static = contents
            self._write(key, contents, frame)
        self.without_ground += not on_ground
        if "overlay" in self._output.kinds:
            overlay = overlay_message(self._overlay, prediction, frame.header)
            self._write("overlay", overlay, frame)

    def _write(self, key: str, contents: Any, frame: BagFrame) -> None:  # noqa: ANN401
        self._bag.write(TOPICS[key], contents, frame.logged_ns)
        self._messages += 1

    def _finish(self) -> bool:
        self._bag.close()
        return self._messages > 0


def overlay_message(
    overlay: VideoOverlay, prediction: GroundMaps, header: Header
) -> CompressedImage:
    """The drawing of a prediction as `sensor_msgs/CompressedImage`, JPEG."""
    _, jpeg = opencv().imencode(".jpg", overlay.draw(prediction))
    return CompressedImage(header, "bgr8; jpeg compressed bgr8", np.ravel(jpeg))


def contents_equal(one: Any, other: Any) -> bool:  # noqa: ANN401 - messages or None
    """Whether two transforms say the same of the same frames, at whatever time."""

    def without_time(message: Any) -> object:  # noqa: ANN401
        return [(t.header.frame_id, t.child_frame_id, t.transform) for t in message.transforms]

    return one is not None and without_time(one) == without_time(other)


_NAME = "bag"


class _McapBag:
    """rosbags writes a folder with an mcap file in it: the file is all that is kept."""

    def __init__(self, path: Path) -> None:
        library = rosbags()
        self._path, self._folder = path, new_part(path.parent)
        self._folder.mkdir()
        self._types = message_types(2)
        self._writer = library.rosbag2.Writer(
            self._folder / _NAME,
            version=_RECORDED_AS,
            storage_plugin=library.rosbag2.StoragePlugin.MCAP,
        )
        self._writer.set_compression(
            library.rosbag2.CompressionMode.STORAGE, library.rosbag2.CompressionFormat.ZSTD
        )
        self._writer.open()
        self._connections: dict[str, Any] = {}

    def write(self, topic: str, contents: Any, logged_ns: int) -> None:  # noqa: ANN401
        kind = contents.TYPE
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_connection(
                topic,
                kind,
                typestore=self._types,
                offered_qos_profiles=[_quality(latched=topic == TOPICS["tf_static"])],
            )
        message = fill(contents, lambda kind, /, **fields: self._types.types[kind](**fields))
        data = self._types.serialize_cdr(message, kind)
        self._writer.write(self._connections[topic], logged_ns, data)

    def close(self) -> None:
        try:
            self._writer.close()
            (self._folder / _NAME / f"{_NAME}.mcap").replace(self._path)
        finally:
            rmtree(self._folder, ignore_errors=True)


class _Ros1Bag:
    """A bag of ROS 1, whose headers have a number as well."""

    def __init__(self, path: Path) -> None:
        path.unlink(missing_ok=True)  # of a run that was killed
        self._types = message_types(1)
        self._writer = rosbags().rosbag1.Writer(path)
        self._writer.open()
        self._connections: dict[str, Any] = {}

    def write(self, topic: str, contents: Any, logged_ns: int) -> None:  # noqa: ANN401
        kind = contents.TYPE
        if topic not in self._connections:
            latching = int(topic == TOPICS["tf_static"])
            self._connections[topic] = self._writer.add_connection(
                topic, kind, typestore=self._types, latching=latching
            )
        data = self._types.serialize_ros1(fill(contents, self._make), kind)
        self._writer.write(self._connections[topic], logged_ns, data)

    def _make(self, kind: str, /, **fields: Any) -> Any:  # noqa: ANN401
        if kind == Header.TYPE:
            fields["seq"] = 0
        return self._types.types[kind](**fields)

    def close(self) -> None:
        self._writer.close()


def _quality(*, latched: bool) -> Any:  # noqa: ANN401 - rosbags is optional
    """Reliable, the last ten messages; of a latched topic the last one, also for late comers."""
    q = rosbags().interfaces
    endless = q.QosTime(2**31 - 1, 2**32 - 1)
    return q.Qos(
        q.QosHistory.KEEP_LAST,
        1 if latched else 10,
        q.QosReliability.RELIABLE,
        q.QosDurability.TRANSIENT_LOCAL if latched else q.QosDurability.VOLATILE,
        endless,
        endless,
        q.QosLiveliness.AUTOMATIC,
        endless,
        False,
    )
