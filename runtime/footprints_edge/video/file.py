"""Writing of video files, which are looked at before they get their name."""

from contextlib import ExitStack, suppress
from pathlib import Path

from footprints_edge.errors import VideoError
from footprints_edge.foundation.opencv import opencv
from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.video.encoders import Encoder, open_encoder
from footprints_edge.video.plain_names import plain_name


class VideoFile:
    """A video file that grows frame by frame."""

    def __init__(self, path: Path, fps: float) -> None:
        """Sets the path; the file is created with the first frame.

        Args:
            path: The file: `.mp4`.
            fps: Frames per second.
        """
        self._cv2 = opencv()
        self._path, self._fps = path, fps
        self._names = ExitStack()
        self._encoder: Encoder | None = None
        self._size: Size | None = None
        self.frames = 0

    def write(self, bgr: Rgb) -> None:
        """Adds a frame, uint8 (H, W, 3), BGR, with even sides; all frames have one size.

        Raises:
            VideoError: If the file cannot be written.
        """
        size = (bgr.shape[0], bgr.shape[1])
        if self._encoder is None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            name = self._names.enter_context(plain_name(self._path))
            self._encoder = open_encoder(self._path, name, self._fps, size)
            self._size = size
        if size != self._size:  # the stream has changed its size
            assert self._size is not None
            bgr = self._cv2.resize(bgr, self._size[::-1], interpolation=self._cv2.INTER_AREA)
        try:
            self._encoder.write(bgr)
        except (OSError, ValueError) as error:  # PyAV's errors are some of each
            raise VideoError(
                f"{self._path} cannot be written: {error}; check the folder and the disk"
            ) from error
        self.frames += 1

    def close(self) -> None:
        """Finishes the file; without frames, there is none.

        Raises:
            VideoError: If it is not whole, as on a full disk; OpenCV itself does not say so.
        """
        if self._encoder is None:
            return
        encoder, self._encoder = self._encoder, None
        try:
            with suppress(OSError, ValueError):  # what it would say is what is looked at below
                encoder.close()
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
