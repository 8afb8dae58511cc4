"""Output files of a video: an overlay video, and JSON Lines with one line per frame."""

import json
from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path

from footprints_edge.errors import OutputError
from footprints_edge.foundation.types import Rgb
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.outputs.json_summary import summarise
from footprints_edge.video.capture import VideoFrame
from footprints_edge.video.file import VideoFile
from footprints_edge.video.overlay import VideoOverlay
from footprints_edge.video.pipeline import Ending

SUFFIXES = {"overlay": ".overlay.mp4", "json": ".jsonl"}
"""The output formats of a video, with the suffix of each file."""

_MAX_REPEATED_S = 10.0
"""A gap in a source is filled up to this length."""

_PER_FRAME_KEYS = (
    "ground_fraction",
    "ground_distance_m",
    "ground_plane",
    "confidence",
    "notes",
    "nearest_obstacle_m",
    "nearest_obstacle_bearing_deg",
    "timings_ms",
)
"""Keys of the `json` output in each line: the others are the same for all frames."""


def video_paths(folder: Path, name: str, formats: Sequence[str]) -> dict[str, Path]:
    """The file of each format, in order.

    Raises:
        OutputError: If a format is unknown, or does not apply to videos.
    """
    unknown = [key for key in formats if key not in SUFFIXES]
    if unknown or not formats:
        raise OutputError(
            f"videos do not support the format {', '.join(unknown) or '(none given)'}; "
            f"choose from {', '.join(SUFFIXES)}"
        )
    return {key: folder / (name + SUFFIXES[key]) for key in formats}


def partial_path(path: Path) -> Path:
    """The name of a file of `video_paths` until it is whole."""
    ending = next(suffix for suffix in SUFFIXES.values() if path.name.endswith(suffix))
    return path.with_name(path.name.removesuffix(ending) + ".partial" + ending)


def open_sinks(
    paths: dict[str, Path], fps: float, *, bev: bool = False, endless: bool = False
) -> "list[FileSink]":
    """Opens the sinks that write the files of `video_paths`.

    A file has the name of `partial_path` until it is whole. The lines of a source without an end,
    such as a camera, have their own name from the start: each of them is whole, and programs follow
    the file.

    Args:
        paths: File of each format.
        fps: Frames per second.
        bev: Whether the overlay has a bird's-eye view beside it.
        endless: Whether the source is one that somebody ends, and whatever came is all.

    Raises:
        OutputError: If a file cannot be created.
        VideoError: If OpenCV is missing.
    """
    sinks: list[FileSink] = []
    for key, path in paths.items():
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            if key == "overlay":
                sinks.append(_OverlayVideo(path, fps, endless=endless, bev=bev))
            else:
                sinks.append(_JsonLines(path, endless=endless))
        except OSError as error:
            for sink in sinks:
                sink.close("failed")
            raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
    return sinks


class FileSink(ABC):
    """A sink that writes a file.

    Attributes:
        written: The file that is there after `close`: whole, or the part of an interrupted video
            under another name; None if there is none.
    """

    def __init__(self, path: Path, *, endless: bool, growing: Path) -> None:
        """Sets the names.

        Args:
            path: The whole file.
            endless: As for `open_sinks`.
            growing: The file until it is whole.
        """
        self.written: Path | None = None
        self._path, self._endless, self._growing = path, endless, growing

    @abstractmethod
    def write(self, frame: VideoFrame, prediction: GroundMaps) -> None:
        """Writes one frame."""

    @abstractmethod
    def _finish(self) -> bool:
        """Finishes the file; whether there is anything in it."""

    def close(self, ending: Ending) -> None:
        """Finishes the file, and gives it its name or removes it.

        Raises:
            OSError: If that fails; there is no file then.
            VideoError: Likewise.
        """
        keep = False
        try:
            keep = self._finish() and ending != "failed"
            if keep and (ending == "whole" or self._endless):
                self._growing.replace(self._path)
                self.written = self._path
            elif keep:
                self.written = self._growing
        except BaseException:
            keep = False
            raise
        finally:
            if not keep:
                self._growing.unlink(missing_ok=True)


class _OverlayVideo(FileSink):
    """Frames that were dropped or broken are shown as the frame before, so the speed is right."""

    def __init__(self, path: Path, fps: float, *, endless: bool, bev: bool) -> None:
        super().__init__(path, endless=endless, growing=partial_path(path))
        self._file = VideoFile(self._growing, fps)
        self._fps = fps
        self._overlay = VideoOverlay(bev=bev)
        self._first_s: float | None = None
        self._last: Rgb | None = None

    def write(self, frame: VideoFrame, prediction: GroundMaps) -> None:
        self._first_s = frame.time_s if self._first_s is None else self._first_s
        missing = round((frame.time_s - self._first_s) * self._fps) - self._file.frames
        if self._last is not None:
            for _ in range(min(missing, round(_MAX_REPEATED_S * self._fps))):
                self._file.write(self._last)
        self._last = self._overlay.draw(prediction)
        self._file.write(self._last)

    def _finish(self) -> bool:
        self._file.close()
        return self._file.frames > 0


class _JsonLines(FileSink):
    """Writes each line as soon as its frame is done, so programs can follow the file."""

    def __init__(self, path: Path, *, endless: bool) -> None:
        super().__init__(path, endless=endless, growing=path if endless else partial_path(path))
        self._lines = 0
        self._file = self._growing.open("w", encoding="ascii", buffering=1)

    def write(self, frame: VideoFrame, prediction: GroundMaps) -> None:
        facts = summarise(prediction)
        line = {"frame": frame.index, "time_s": round(frame.time_s, 4)}
        line |= {key: facts[key] for key in _PER_FRAME_KEYS}
        self._file.write(json.dumps(line, allow_nan=False) + "\n")
        self._lines += 1

    def _finish(self) -> bool:
        self._file.close()
        return self._lines > 0
