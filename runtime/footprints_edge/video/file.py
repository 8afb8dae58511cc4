"""Writing of video files, which are looked at before they get their name."""

from contextlib import ExitStack
from pathlib import Path
from typing import Any

from footprints_edge.errors import VideoError
from footprints_edge.foundation.opencv import opencv
from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.video.plain_names import plain_name

_MAX_CLOCK = 65535
"""Largest number of ticks per second that MPEG-4 video has room for."""


class VideoFile:
    """A video file that grows frame by frame."""

    def __init__(self, path: Path, fps: float) -> None:
        """Sets the path; the file is created with the first frame.

        Args:
            path: The file: `.mp4`, MPEG-4 video.
            fps: Frames per second.
        """
        self._cv2 = opencv()
        self._path, self._fps = path, _writable_fps(fps)
        self._names = ExitStack()
        self._writer: Any = None
        self._size: Size | None = None
        self.frames = 0

    def write(self, bgr: Rgb) -> None:
        """Adds a frame, uint8 (H, W, 3), BGR, with even sides; all frames have one size.

        Raises:
            VideoError: If the file cannot be written.
        """
        size = (bgr.shape[0], bgr.shape[1])
        if self._writer is None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            code = self._cv2.VideoWriter_fourcc(*"mp4v")
            name = self._names.enter_context(plain_name(self._path))
            self._writer = self._cv2.VideoWriter(
                name, self._cv2.CAP_FFMPEG, code, self._fps, size[::-1]
            )
            self._size = size
            if not self._writer.isOpened():
                raise VideoError(
                    f"{self._path} cannot be written as MPEG-4 video of {size[1]} x {size[0]} "
                    f"pixels and {self._fps:g} frames per second; check the folder, or install "
                    "an OpenCV with FFmpeg"
                )
        if size != self._size:  # the stream has changed its size
            assert self._size is not None
            bgr = self._cv2.resize(bgr, self._size[::-1], interpolation=self._cv2.INTER_AREA)
        self._writer.write(bgr)
        self.frames += 1

    def close(self) -> None:
        """Finishes the file; without frames, there is none.

        Raises:
            VideoError: If it is not whole, as on a full disk: OpenCV itself does not say so.
        """
        if self._writer is None:
            return
        self._writer.release()
        self._writer = None
        try:
            whole = self._last_frame_is_there()
        finally:
            self._names.close()
        if not whole:
            raise VideoError(f"{self._path} cannot be written whole; is the disk full?")

    def _last_frame_is_there(self) -> bool:
        if not self._path.is_file():
            return False
        with plain_name(self._path) as name:
            capture = self._cv2.VideoCapture(name, self._cv2.CAP_FFMPEG)
        try:
            if capture.get(self._cv2.CAP_PROP_FRAME_COUNT) != self.frames:
                return False
            capture.set(self._cv2.CAP_PROP_POS_FRAMES, self.frames - 1)
            return bool(capture.grab())
        finally:
            capture.release()


def _writable_fps(fps: float) -> float:
    """The rate that MPEG-4 can state, nearest to another: OpenCV writes it with decimals."""
    decimals = next((n for n in (3, 2, 1) if fps * 10**n <= _MAX_CLOCK), 0)
    return max(round(fps, decimals), 0.001)
