"""Capture of frames from videos, cameras and pipes."""

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic, sleep
from typing import Any, BinaryIO

import numpy as np

from footprints_edge.errors import VideoError
from footprints_edge.foundation.addresses import is_address, without_password
from footprints_edge.foundation.opencv import opencv
from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.inputs.images import DecodedImage
from footprints_edge.video.plain_names import plain_name
from footprints_edge.video.sources import CAMERA, STDIN, is_live

USUAL_FPS = 30.0
"""Frames per second of a source that does not state its rate."""

_MAX_BROKEN = 30
"""A file ends after more than this many broken frames in a row."""

_COUNT_TOLERANCE = 2
"""Containers may announce up to this many frames more than they hold."""

_TIMEOUT_S = 5.0
"""A live source that is silent for this long has ended."""

_POLL_S = 0.02

MAX_RAW_PX = 2**25
"""Most pixels of a raw frame: an 8K picture has fewer. Some twelve frames are held at once."""


@dataclass(frozen=True, eq=False)
class VideoFrame:
    """One frame of a video.

    Attributes:
        index: Position in the video, from 0; skipped frames count.
        time_s: Seconds since the first frame, by the video's clock, or by ours for live sources.
        rgb: uint8 (H, W, 3); None if the frame is broken.
    """

    index: int
    time_s: float
    rgb: Rgb | None

    @property
    def image(self) -> DecodedImage:
        """The frame as the model takes it; for frames that are not broken."""
        assert self.rgb is not None
        return DecodedImage(self.rgb)


@dataclass(frozen=True)
class RawFormat:
    """Layout of raw frames in a pipe: RGB, three bytes per pixel, row by row.

    Attributes:
        size: (H, W).
        fps: Frames per second.
    """

    size: Size
    fps: float = USUAL_FPS

    @classmethod
    def parse(cls, text: str) -> "RawFormat":
        """Parses `640x360` or `640x360@25`: width first, as in ffmpeg.

        Raises:
            VideoError: If the text has another form.
        """
        sides, _, fps = text.partition("@")
        try:
            width, height = (int(side) for side in sides.lower().split("x"))
            found = cls((height, width), float(fps or USUAL_FPS))
        except ValueError:
            found = None
        if found is None or min(found.size) < 1 or not 0 < found.fps < 1e4:
            raise VideoError(
                f"{text!r} is not a raw frame size; give WIDTHxHEIGHT[@FPS], such as 640x360@25"
            )
        if found.size[0] * found.size[1] > MAX_RAW_PX:
            raise VideoError(
                f"{text!r} is more than the {MAX_RAW_PX} pixels that a raw frame may have; "
                "scale the frames down first"
            )
        return found


@dataclass(frozen=True)
class Pace:
    """Selects the frames to process.

    Attributes:
        every: Process every Nth frame.
        max_fps: Maximum number of frames per second of the video's time; None means no limit.
    """

    every: int = 1
    max_fps: float | None = None

    def __post_init__(self) -> None:
        """Rejects numbers that select no frames.

        Raises:
            VideoError: If a number is not positive.
        """
        if self.every < 1 or (self.max_fps is not None and not self.max_fps > 0):
            raise VideoError(
                f"every is {self.every} and max_fps is {self.max_fps}; give positive numbers"
            )

    def clock(self) -> "PaceClock":
        """What decides frame by frame, from the first frame on."""
        return PaceClock(self)

    def fps_of(self, source_fps: float) -> float:
        """Frames per second that remain of a source's rate."""
        return min(source_fps / self.every, self.max_fps or np.inf)


class PaceClock:
    """Decides which frames of one video to process.

    The next frame is due 1 / `max_fps` after the last one was due, not after it came: so that many
    frames per second remain, whatever the rate of the video.
    """

    def __init__(self, pace: Pace) -> None:
        """Starts before the first frame."""
        self._pace = pace
        self._due_s: float | None = None

    def takes(self, index: int, time_s: float) -> bool:
        """Whether to process a frame; to be asked of each one once, in order."""
        if index % self._pace.every:
            return False
        if self._pace.max_fps is None:
            return True
        due_s = time_s if self._due_s is None else self._due_s
        if time_s + 5e-4 < due_s:  # containers round their times
            return False
        between_s = 1 / self._pace.max_fps
        self._due_s = due_s + between_s if due_s + between_s > time_s else time_s + between_s
        return True


@dataclass(frozen=True, eq=False)
class Video:
    """An open video.

    Attributes:
        name: Name of its outputs.
        live: Whether frames arrive in real time, like those of a camera, and cannot wait.
        fps: Frames per second that `frames` yields.
        frames: The frames in order. Closing the iterator closes the source.
        total: Expected number of frames, None if unknown.
        path: The video file, None if there is none.
    """

    name: str
    live: bool
    fps: float
    frames: Iterator[VideoFrame] = field(repr=False)
    total: int | None = None
    path: Path | None = None


def open_video(named: str, pace: Pace = Pace()) -> Video:
    """Opens a video file, `camera:N` or a stream such as `rtsp://HOST/PATH`.

    Raises:
        VideoError: If it cannot be opened, or OpenCV is missing.
    """
    cv2 = opencv()
    live, shown = is_live(named), without_password(named)
    with ExitStack() as stack:
        if named.lower().startswith(CAMERA):
            number = named[len(CAMERA) :]
            if not number.isdecimal() or len(number) > 4:
                raise VideoError(f"{named}: give the camera's number, such as {CAMERA}0")
            capture = cv2.VideoCapture(int(number))
            name = f"camera{int(number)}"
        elif live:
            timeouts = [
                cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, int(1000 * _TIMEOUT_S),
                cv2.CAP_PROP_READ_TIMEOUT_MSEC, int(1000 * _TIMEOUT_S),
            ]  # fmt: skip
            capture = cv2.VideoCapture(named, cv2.CAP_FFMPEG, timeouts)
            # keep user:password out of file names
            address = named.split("://", 1)[1].rpartition("@")[2].partition("?")[0]
            name = "".join(c if c.isalnum() or c in ".-" else "_" for c in address)
        else:
            if not Path(named).is_file():
                raise VideoError(f"{shown}: {_why_no_video(named)}")
            capture = cv2.VideoCapture(stack.enter_context(plain_name(Path(named))))
            name = Path(named).name
    if not capture.isOpened():
        capture.release()
        raise VideoError(
            f"{shown} cannot be opened: "
            + (
                "no answer; check the address or the camera's number"
                if live
                else "it is not a video that OpenCV can read; convert it to MP4"
            )
        )
    stated_fps = capture.get(cv2.CAP_PROP_FPS)
    fps = stated_fps if 0 < stated_fps < 1000 else USUAL_FPS
    count = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    count_known = not live and count > 0
    processed_share = pace.fps_of(fps) / fps
    return Video(
        name,
        live,
        pace.fps_of(fps),
        _captured(cv2, capture, pace, fps, shown if live else None),
        round(count * processed_share) if count_known else None,
        None if live else Path(named),
    )


def _why_no_video(named: str) -> str:
    if is_address(named):
        return "addresses of streams begin with rtsp:// or rtsps://; download a file first"
    if Path(named).is_dir():
        return "it is a folder; give a video in it"
    return "it is not a file" if Path(named).exists() else "no such file"


def open_raw(layout: RawFormat, pace: Pace = Pace(), pipe: BinaryIO | None = None) -> Video:
    """Reads raw RGB frames from a pipe; None means standard input.

    The writer of the pipe waits, so no frame is dropped.

    Raises:
        VideoError: If this process has no standard input.
    """
    if pipe is None:
        if sys.stdin is None:
            raise VideoError("there is no standard input; pipe frames into this command")
        pipe = sys.stdin.buffer
    frames = _piped(pipe, layout, pace)
    return Video("stdin", False, pace.fps_of(layout.fps), frames)


def open_source(
    source: str | os.PathLike[str] | BinaryIO, pace: Pace = Pace(), raw: str | None = None
) -> Video:
    """Opens what `Model.stream` takes.

    Args:
        source: A name, as for `open_video`; with `raw` a binary file object, or `-`.
        pace: The frames to process.
        raw: Layout of the frames in a pipe, as for `RawFormat.parse`.

    Raises:
        VideoError: If it cannot be opened, or it is a pipe without a layout or the reverse.
    """
    if isinstance(source, str | os.PathLike):
        named, pipe = os.fsdecode(source), None
    else:
        named, pipe = STDIN, source
    if raw is None and named != STDIN:
        return open_video(named, pace)
    if raw is not None and named == STDIN:
        return open_raw(RawFormat.parse(raw), pace, pipe)
    raise VideoError(
        f"raw is {raw!r} for {without_password(named)}; a pipe needs the layout of its frames, "
        "such as raw='640x360@25', and nothing else has one"
    )


def _captured(
    cv2: Any,  # noqa: ANN401
    capture: Any,  # noqa: ANN401
    pace: Pace,
    fps: float,
    live: str | None,
) -> Iterator[VideoFrame]:
    """The frames of an OpenCV capture; frames that `pace` skips are not converted to RGB."""
    count = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    index, missed = 0, 0
    start_s, received_s = None, monotonic()
    clock = pace.clock()
    try:
        while True:
            if not capture.grab():
                # a damaged frame fails, but later ones may be good
                missed += 1
                if live and monotonic() - received_s > _TIMEOUT_S:
                    raise VideoError(
                        f"{live} has sent nothing for {_TIMEOUT_S:g} s; check its connection"
                    )
                if live:
                    sleep(_POLL_S)
                elif missed > _MAX_BROKEN or index + missed >= count:
                    break
                continue
            received_s = monotonic()
            start_s = received_s if start_s is None else start_s
            if live:  # what was missed are looks for a frame: one gap
                if missed and index:
                    yield VideoFrame(index, received_s - start_s, None)
                    index += 1
            else:
                yield from _broken(index, missed, fps)
                index += missed
            missed = 0
            stated_s = capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
            time_s = index / fps if stated_s <= 0 else stated_s
            if live:
                time_s = received_s - start_s
            if clock.takes(index, time_s):
                good, bgr = capture.retrieve()
                rgb = cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB) if good else None
                yield VideoFrame(index, time_s, rgb)
            index += 1
        if missed > _COUNT_TOLERANCE:
            yield from _broken(index, missed, fps)
    finally:
        capture.release()


def _broken(index: int, count: int, fps: float) -> Iterator[VideoFrame]:
    """Broken frames in place of `count` missing ones, from `index` on."""
    return (VideoFrame(each, each / fps, None) for each in range(index, index + count))


def _piped(pipe: BinaryIO, layout: RawFormat, pace: Pace) -> Iterator[VideoFrame]:
    height, width = layout.size
    length = height * width * 3
    index, clock = 0, pace.clock()
    while data := _read(pipe, length):
        time_s = index / layout.fps
        if clock.takes(index, time_s):
            whole = len(data) == length
            rgb = np.frombuffer(data, np.uint8).reshape(height, width, 3) if whole else None
            yield VideoFrame(index, time_s, rgb)
        index += 1


def _read(pipe: BinaryIO, length: int) -> bytes:
    """So many bytes, or fewer at the end: an unbuffered pipe gives what there is at the moment."""
    parts: list[bytes] = []
    while left := length - sum(map(len, parts)):
        part = pipe.read(left)
        if not isinstance(part, bytes):  # text, or None: nothing is there at the moment
            raise VideoError("the pipe gives no bytes; open it in binary mode, and blocking")
        if not part:
            break
        parts.append(part)
    return b"".join(parts)
