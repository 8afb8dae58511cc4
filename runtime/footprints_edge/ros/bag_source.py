"""The pictures of a bag as a video, with their stamps, frames and cameras."""

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from footprints_edge.errors import BagError, FootprintsError, IntrinsicsError, VideoError
from footprints_edge.inputs.images import DecodedImage
from footprints_edge.ros.camera_info import LatestCamera
from footprints_edge.ros.image_messages import picture_of
from footprints_edge.ros.messages import Header, Time
from footprints_edge.ros.rosbags_library import open_reader
from footprints_edge.video.capture import USUAL_FPS, Pace, Video, VideoFrame

if TYPE_CHECKING:
    from footprints_edge.foundation.types import Size
    from footprints_edge.geometry.camera import Intrinsics
    from footprints_edge.inputs.calibration import Calibration

_IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
_CAMERA_INFO = "sensor_msgs/msg/CameraInfo"


@dataclass(frozen=True, eq=False)
class BagFrame(VideoFrame):
    """One picture of a bag.

    Attributes:
        logged_ns: When it was recorded, nanoseconds: by this time the bag is sorted.
        header: Its own stamp and frame.
        picture: The picture; None if the message is bad.
        camera: What its `CameraInfo` states, for `Model.predict`; None without one.
    """

    logged_ns: int
    header: Header
    picture: DecodedImage | None
    camera: "Calibration | Callable[[Size], Intrinsics] | None"

    @property
    def image(self) -> DecodedImage:
        """The picture, of a frame that is not broken."""
        assert self.picture is not None
        return self.picture


@dataclass(frozen=True)
class Topics:
    """The topics of a bag that are read.

    Attributes:
        images: Topic of the pictures.
        camera: Topic of their `CameraInfo`; None if the bag has none for them.
        rectified: Whether the pictures are rectified already.
    """

    images: str
    camera: str | None
    rectified: bool


def open_bag(
    path: Path,
    pace: Pace,
    *,
    topic: str | None = None,
    with_camera: bool = True,
    on_bad: Callable[[str], None] = lambda _: None,
) -> tuple[Video, Topics]:
    """Opens a bag of ROS 1 (`.bag`) or ROS 2 (`.mcap`, `.db3`, or a folder).

    Args:
        path: The bag.
        pace: Which pictures to process; rates refer to the time of recording.
        topic: Topic of the pictures; None if there is one camera only.
        with_camera: Whether to read `CameraInfo`.
        on_bad: Called with the name of each message that cannot be used, and the reason.

    Returns:
        The bag as a video of `BagFrame`, and the topics.

    Raises:
        BagError: If it cannot be read, has no pictures, or several cameras and no topic was given.
        IntrinsicsError: If its `CameraInfo` cannot be used.
    """
    reader = open_reader(path)
    try:
        topics = choose_topics(
            path, {each.topic: each.msgtype for each in reader.connections}, topic
        )
        infos = [each for each in reader.connections if with_camera and each.topic == topics.camera]
        images = [each for each in reader.connections if each.topic == topics.images]
        pictures = _Pictures(reader, images, infos, topics, pace, on_bad)
        if infos:
            pictures.read_first_camera(path)
        total = sum(each.msgcount for each in images)
        seconds = reader.duration / 1e9
    except BaseException:
        reader.close()
        raise
    fps = total / seconds if total > 1 and seconds > 0 else USUAL_FPS
    kept = -(-total // pace.every)
    video = Video(path.name, False, pace.fps_of(fps), pictures.frames(), kept or None, path)
    return video, topics


def choose_topics(path: Path, types: dict[str, str], topic: str | None) -> Topics:
    """The topics of the pictures and of their camera.

    Args:
        path: The bag, for messages.
        types: Message type of each of its topics.
        topic: The topic that is wanted; None if the bag has pictures of one camera only.

    Raises:
        BagError: If there is no such topic, or several.
    """
    pictures = sorted(name for name, kind in types.items() if kind in _IMAGES)
    listed = ", ".join(pictures)
    if topic is not None:
        topic = "/" + topic.lstrip("/")
        if topic not in pictures:
            kind = f"is {types[topic]}" if topic in types else "is not in it"
            has = f"its pictures are {listed}" if listed else "it has no pictures"
            raise BagError(f"{path}: the topic {topic} {kind}; {has}")
        chosen = topic
    else:
        cameras = [
            name
            for name in pictures
            if not name.endswith("/compressedDepth")
            and not (name.endswith("/compressed") and _base(name) in pictures)
        ]
        if not cameras:
            raise BagError(
                f"{path} has no pictures (sensor_msgs Image or CompressedImage); its topics are "
                f"{', '.join(sorted(types)) or '(none)'}"
            )
        if len(cameras) > 1:
            raise BagError(f"{path} has several topics of pictures; give --topic, one of {listed}")
        chosen = cameras[0]
    base = _base(chosen) if types[chosen] == _IMAGES[1] else chosen
    beside = [f"{base.rpartition('/')[0]}/camera_info", f"{base}/camera_info"]
    camera = next((name for name in beside if types.get(name) == _CAMERA_INFO), None)
    return Topics(chosen, camera, base.rpartition("/")[2].startswith("image_rect"))


def _base(topic: str) -> str:
    """The topic of the camera, of one by `image_transport`: without `/compressed`."""
    return topic.rpartition("/")[0] or topic


class _Pictures:
    """The messages of a bag, one after the other."""

    def __init__(
        self,
        reader: Any,  # noqa: ANN401 - rosbags is optional
        images: list[Any],
        infos: list[Any],
        topics: Topics,
        pace: Pace,
        on_bad: Callable[[str], None],
    ) -> None:
        self._reader, self._images, self._infos = reader, images, infos
        self._topics, self._pace, self._on_bad = topics, pace, on_bad
        self._latest = LatestCamera(rectified=topics.rectified)

    def read_first_camera(self, path: Path) -> None:
        """Reads the first `CameraInfo`, which may stand after the first picture."""
        for connection, _, raw in self._reader.messages(connections=self._infos):
            try:
                self._latest.read(self._reader.deserialize(raw, connection.msgtype))
            except Exception as error:
                raise IntrinsicsError(
                    f"{path}: {connection.topic} cannot be used ({error}); give the camera by "
                    "--camera, or --fx and --fy"
                ) from error
            return

    def frames(self) -> Iterator[BagFrame]:
        """The pictures in the order of recording.

        A camera whose focal length changes has a `CameraInfo` for each picture, of the same stamp.
        It may be recorded after the picture, which waits for it until the next picture comes.
        """
        with closing(self._reader):
            waiting: BagFrame | None = None
            for item in self._messages():
                if isinstance(item, Time):
                    if waiting is not None and waiting.header.stamp == item:
                        yield replace(waiting, camera=self._latest.camera)
                        waiting = None
                    continue
                if waiting is not None:
                    yield waiting
                waiting = item
            if waiting is not None:
                yield waiting

    def _messages(self) -> Iterator[BagFrame | Time]:
        """The pictures, and the stamps of the cameras that were read between them."""
        index, clock, first_ns = 0, self._pace.clock(), None
        messages = self._reader.messages(connections=[*self._images, *self._infos])
        while True:
            try:
                connection, logged_ns, raw = next(messages)
            except StopIteration:
                return
            except Exception as error:  # a damaged file
                self._on_bad(f"the bag cannot be read further ({type(error).__name__}: {error})")
                return
            if connection.topic == self._topics.camera:
                try:
                    info = self._reader.deserialize(raw, connection.msgtype)
                    self._latest.read(info)
                    yield _time(info)
                except Exception as error:
                    self._on_bad(f"{connection.topic}: {error}; the camera before it holds")
                continue
            first_ns = logged_ns if first_ns is None else first_ns
            time_s = (logged_ns - first_ns) / 1e9
            if clock.takes(index, time_s):
                yield self._frame(index, time_s, logged_ns, connection, raw)
            index += 1

    def _frame(
        self,
        index: int,
        time_s: float,
        logged_ns: int,
        connection: Any,  # noqa: ANN401 - rosbags is optional
        raw: bytes,
    ) -> BagFrame:
        header = Header(Time(*divmod(logged_ns, 10**9)), "")
        picture = None
        try:
            message = self._reader.deserialize(raw, connection.msgtype)
            header = Header(_time(message), message.header.frame_id)
            picture = picture_of(message)
        except VideoError:
            raise  # OpenCV is missing
        except Exception as error:  # damaged messages give any error of their parser
            reason = str(error) if isinstance(error, FootprintsError) else repr(error)
            self._on_bad(message_name(self._topics.images, index, header) + f": {reason}")
        rgb = None if picture is None else picture.pixels
        return BagFrame(index, time_s, rgb, logged_ns, header, picture, self._latest.camera)


def message_name(topic: str, index: int, header: Header) -> str:
    """The name of a message in notes."""
    return f"{topic}, message {index}, stamp {header.stamp.sec}.{header.stamp.nanosec:09d}"


def _time(message: Any) -> Time:  # noqa: ANN401 - rosbags is optional
    return Time(int(message.header.stamp.sec), int(message.header.stamp.nanosec))
