"""Encoders of video files: H.264 by PyAV, else MPEG-4 by OpenCV, which browsers do not play."""

from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol

from footprints_edge.errors import VideoError
from footprints_edge.foundation.opencv import opencv
from footprints_edge.foundation.types import Rgb, Size

_QUALITY = {"preset": "ultrafast", "crf": "21"}
"""Of x264: files are as large as OpenCV's MPEG-4, and take twice as long."""

_BT601, _LIMITED = 6, 1
"""What OpenCV converts to; without it, players take large pictures for BT.709."""

_MAX_CLOCK = 65535
"""Largest number of ticks per second that MPEG-4 video has room for."""


class Encoder(Protocol):
    """Writes frames of one size to a file."""

    def write(self, bgr: Rgb) -> None:
        """Adds a frame, uint8 (H, W, 3), BGR."""

    def close(self) -> None:
        """Finishes the file."""


def open_encoder(path: Path, name: str, fps: float, size: Size) -> Encoder:
    """Opens an encoder.

    Args:
        path: The file, for messages.
        name: Its name for FFmpeg, see `plain_name`.
        fps: Frames per second.
        size: (H, W) of the frames; both are even.

    Raises:
        VideoError: If the file cannot be written.
    """
    try:
        return _H264(name, fps, size) if _has_x264() else _Mpeg4(name, fps, size)
    except (OSError, ValueError) as error:  # PyAV's errors are some of each
        raise VideoError(
            f"{path} cannot be written as video of {size[1]} x {size[0]} pixels and {fps:g} "
            f"frames per second: {error}; check the folder"
        ) from error


def _has_x264() -> bool:
    """Whether there is a PyAV, and one with x264: builds of distributions lack it."""
    if find_spec("av") is None:
        return False
    import av

    return "libx264" in av.codecs_available


class _H264:
    def __init__(self, name: str, fps: float, size: Size) -> None:
        import av

        self._av: Any = av
        self._cv2 = opencv()
        rate = Fraction(fps).limit_denominator(1001)
        self._file = av.open(name, "w", format="mp4")
        try:
            self._stream: Any = self._file.add_stream("libx264", rate=rate, options=_QUALITY)
            self._stream.height, self._stream.width = size
            self._stream.pix_fmt = "yuv420p"  # what all players know
            context = self._stream.codec_context
            context.thread_count = 1  # the other cores predict
            context.colorspace, context.color_range = _BT601, _LIMITED
            self._file.start_encoding()  # now, so that an error comes now
        except Exception:
            self._file.close()
            raise

    def write(self, bgr: Rgb) -> None:
        # PyAV's own conversion rounds grey to a tint
        yuv = self._cv2.cvtColor(bgr, self._cv2.COLOR_BGR2YUV_I420)
        frame = self._av.VideoFrame.from_ndarray(yuv, format="yuv420p")
        self._file.mux(self._stream.encode(frame))

    def close(self) -> None:
        try:
            self._file.mux(self._stream.encode(None))
        finally:
            self._file.close()


class _Mpeg4:
    def __init__(self, name: str, fps: float, size: Size) -> None:
        cv2 = opencv()
        code = cv2.VideoWriter_fourcc(*"mp4v")
        self._writer: Any = cv2.VideoWriter(
            name, cv2.CAP_FFMPEG, code, _writable_fps(fps), size[::-1]
        )
        if not self._writer.isOpened():
            raise OSError("OpenCV gives no reason; it may lack FFmpeg")

    def write(self, bgr: Rgb) -> None:
        self._writer.write(bgr)

    def close(self) -> None:
        self._writer.release()


def _writable_fps(fps: float) -> float:
    """The rate that MPEG-4 can state, nearest to another: OpenCV writes it with decimals."""
    decimals = next((n for n in (3, 2, 1) if fps * 10**n <= _MAX_CLOCK), 0)
    return max(round(fps, decimals), 0.001)
