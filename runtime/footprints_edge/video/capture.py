"""Frames of videos, cameras and pipes, in order, each with its time."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic, sleep
from typing import Any, BinaryIO

import numpy as np

from footprints_edge.errors import VideoError
from footprints_edge.foundation.opencv import opencv
from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.video.sources import CAMERA, STREAMS

USUAL_FPS = 30.0
"""Frames a second of a source that does not say how many it has."""

_MOST_BROKEN = 30
"""After so many broken frames in a row, a file has ended."""

_ROUNDED = 2
"""Containers may announce so many frames more than there are."""

_GONE_S = 5.0
"""A live source that is silent for so long has ended."""

_WAIT_S = 0.02


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame of a video.

    Attributes:
        index: Its place in the video, from 0; frames that are left out count.
        time_s: Seconds since the first frame: by the video's clock, for live sources by ours.
        rgb: uint8 (H, W, 3); None where it is broken.
    """

    index: int
    time_s: float
    rgb: Rgb | None


@dataclass(frozen=True)
class RawFormat:
    """How raw frames follow each other in a pipe: three bytes a pixel, RGB, row by row.

    Attributes:
        size: (H, W).
        fps: Frames a second.
    """

    size: Size
    fps: float = USUAL_FPS

    @classmethod
    def parse(cls, text: str) -> "RawFormat":
        """From `640x360` or `640x360@25`: width first, as ffmpeg has it.

        Raises:
            VideoError: If the text is something else.
        """
        sides, _, fps = text.partition("@")
        try:
            width, height = (int(side) for side in sides.lower().split("x"))
            found = cls((height, width), float(fps or USUAL_FPS))
        except ValueError:
            found = None
        if found is None or min(found.size) < 1 or not 0 < found.fps < 1e4:
            raise VideoError(f"raw frames of {text!r}: give width x height, such as 640x360@25")
        return found


@dataclass(frozen=True)
class Pace:
    """Which frames are looked at.

    Attributes:
        every: Every so manieth.
        max_fps: At most so many a second of the video's time; None means all.
    """

    every: int = 1
    max_fps: float | None = None

    def __post_init__(self) -> None:
        """Refuses paces that take nothing.

        Raises:
            VideoError: If a number is not positive.
        """
        if self.every < 1 or (self.max_fps is not None and not self.max_fps > 0):
            raise VideoError(
                f"every is {self.every} and max_fps is {self.max_fps}; give positive numbers"
            )

    def takes(self, index: int, time_s: float, last_s: float | None) -> bool:
        """Whether a frame is looked at, when the last one that was had the time `last_s`."""
        if index % self.every:
            return False
        # half a millisecond: containers round their times
        return self.max_fps is None or last_s is None or time_s - last_s + 5e-4 > 1 / self.max_fps

    def fps_of(self, source_fps: float) -> float:
        """Frames a second that are left of a source's."""
        return min(source_fps / self.every, self.max_fps or np.inf)


@dataclass(frozen=True, eq=False)
class Video:
    """A video that is open.

    Attributes:
        name: What its outputs are named after.
        live: Whether it goes on whether or not anyone looks.
        fps: Frames a second that `frames` yields.
        frames: In order. Closing the iterator closes the source.
        total: How many there will be, None where nobody knows.
        path: The file that it is read from.
    """

    name: str
    live: bool
    fps: float
    frames: Iterator[Frame] = field(repr=False)
    total: int | None = None
    path: Path | None = None


def open_video(named: str, pace: Pace = Pace()) -> Video:
    """Opens a video file, `camera:N` or a stream such as `rtsp://HOST/PATH`.

    Raises:
        VideoError: If it cannot be opened, or OpenCV is missing.
    """
    cv2 = opencv()
    live = named.startswith((CAMERA, *STREAMS))
    if named.startswith(CAMERA):
        number = named.removeprefix(CAMERA)
        if not number.isdecimal():
            raise VideoError(f"{named}: give the camera's number, such as {CAMERA}0")
        capture = cv2.VideoCapture(int(number))
        name = f"camera{number}"
    elif live:
        patience = [
            cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, int(1000 * _GONE_S),
            cv2.CAP_PROP_READ_TIMEOUT_MSEC, int(1000 * _GONE_S),
        ]  # fmt: skip
        capture = cv2.VideoCapture(named, cv2.CAP_FFMPEG, patience)
        # no user:password in file names
        place = named.split("://", 1)[1].rpartition("@")[2]
        name = "".join(c if c.isalnum() or c in ".-" else "_" for c in place)
    else:
        if not Path(named).is_file():
            raise VideoError(f"{named}: no such file")
        capture = cv2.VideoCapture(named)
        name = Path(named).name
    if not capture.isOpened():
        capture.release()
        raise VideoError(
            f"{named} cannot be opened: "
            + ("nothing answers there" if live else "it is no video that OpenCV can read")
        )
    stated_fps = capture.get(cv2.CAP_PROP_FPS)
    fps = stated_fps if 0 < stated_fps < 1000 else USUAL_FPS
    count = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    known = not live and count > 0
    every_other = pace.fps_of(fps) / fps
    return Video(
        name,
        live,
        pace.fps_of(fps),
        _captured(cv2, capture, pace, fps, named if live else None),
        round(count * every_other) if known else None,
        None if live else Path(named),
    )


def open_raw(layout: RawFormat, pace: Pace = Pace(), pipe: BinaryIO | None = None) -> Video:
    """Reads raw RGB frames from a pipe; None means standard input.

    The pipe waits for us: no frame is dropped.
    """
    frames = _piped(pipe or sys.stdin.buffer, layout, pace)
    return Video("stdin", False, pace.fps_of(layout.fps), frames)


def _captured(
    cv2: Any,  # noqa: ANN401
    capture: Any,  # noqa: ANN401
    pace: Pace,
    fps: float,
    live: str | None,
) -> Iterator[Frame]:
    """The frames of an OpenCV capture; those that `pace` leaves out are not decoded to RGB."""
    count = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    index, missed = 0, 0
    began_s = came_s = monotonic()
    last_s = None
    try:
        while True:
            if not capture.grab():
                # what is damaged fails, and what comes after it may be good
                missed += 1
                if live and monotonic() - came_s > _GONE_S:
                    raise VideoError(f"{live} has sent nothing for {_GONE_S:g} s")
                if live:
                    sleep(_WAIT_S)
                elif missed > _MOST_BROKEN or index + missed >= count:
                    break
                continue
            yield from _broken(index, 1 if live and missed else missed, fps)
            index, missed, came_s = index + missed, 0, monotonic()
            stated_s = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
            time_s = index / fps if stated_s <= 0 else stated_s
            if live:
                time_s = came_s - began_s
            if pace.takes(index, time_s, last_s):
                last_s = time_s
                good, bgr = capture.retrieve()
                yield Frame(index, time_s, cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB) if good else None)
            index += 1
        if missed > _ROUNDED:
            yield from _broken(index, missed, fps)
    finally:
        capture.release()


def _broken(index: int, count: int, fps: float) -> Iterator[Frame]:
    """So many frames that did not come, from `index` on."""
    return (Frame(each, each / fps, None) for each in range(index, index + count))


def _piped(pipe: BinaryIO, layout: RawFormat, pace: Pace) -> Iterator[Frame]:
    height, width = layout.size
    length = height * width * 3
    index, last_s = 0, None
    while data := pipe.read(length):
        time_s = index / layout.fps
        if pace.takes(index, time_s, last_s):
            last_s = time_s
            whole = len(data) == length
            rgb = np.frombuffer(data, np.uint8).reshape(height, width, 3) if whole else None
            yield Frame(index, time_s, rgb)
        index += 1


class VideoFile:
    """A video being written: frames go to a file beside its place, which `close` renames."""

    def __init__(self, path: Path, fps: float) -> None:
        """Names the file; it is begun with the first frame.

        Args:
            path: Where it will be: `.mp4`, MPEG-4 video.
            fps: Frames a second.
        """
        self._cv2 = opencv()
        self._path, self._fps = path, fps
        self._begun = path.with_name(f".fp-{path.name}")
        self._writer: Any = None
        self._size: Size | None = None

    def write(self, bgr: Rgb) -> None:
        """Adds a frame, uint8 (H, W, 3), blue, green, red, even sides; all frames of one size.

        Raises:
            VideoError: If the file cannot be written.
        """
        size = (bgr.shape[0], bgr.shape[1])
        if self._writer is None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            code = self._cv2.VideoWriter_fourcc(*"mp4v")
            self._writer = self._cv2.VideoWriter(str(self._begun), code, self._fps, size[::-1])
            self._size = size
            if not self._writer.isOpened():
                raise VideoError(f"{self._path} cannot be written as MPEG-4 video")
        if size != self._size:  # a stream that changed its size
            assert self._size is not None
            bgr = self._cv2.resize(bgr, self._size[::-1], interpolation=self._cv2.INTER_AREA)
        self._writer.write(bgr)

    def close(self) -> None:
        """Ends the file; without a frame there is none."""
        if self._writer is not None:
            self._writer.release()
            self._writer = None
            self._begun.replace(self._path)
