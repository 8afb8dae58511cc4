"""Output files of a video: an overlay video, and JSON Lines with one line per frame."""

import json
from collections.abc import Sequence
from pathlib import Path

from footprints_edge.errors import OutputError
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.outputs.json_summary import summarise
from footprints_edge.video.capture import VideoFile, VideoFrame
from footprints_edge.video.overlay import VideoOverlay
from footprints_edge.video.pipeline import Sink

SUFFIXES = {"overlay": ".overlay.mp4", "json": ".jsonl"}
"""The output formats of a video, with the suffix of each file."""

_PER_FRAME_KEYS = ("ground_fraction", "ground_distance_m", "timings_ms")
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


def open_sinks(paths: dict[str, Path], fps: float, *, bev: bool = False) -> list[Sink]:
    """Opens the sinks that write the files of `video_paths`.

    Args:
        paths: File of each format.
        fps: Frames per second.
        bev: Whether the overlay has a bird's-eye view beside it.

    Raises:
        OutputError: If a file cannot be created.
        VideoError: If OpenCV is missing.
    """
    sinks: list[Sink] = []
    for key, path in paths.items():
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            if key == "overlay":
                sinks.append(_OverlayVideo(path, fps, bev=bev))
            else:
                sinks.append(_JsonLines(path))
        except OSError as error:
            raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
    return sinks


class _OverlayVideo:
    def __init__(self, path: Path, fps: float, *, bev: bool) -> None:
        self._file = VideoFile(path, fps)
        self._overlay = VideoOverlay(bev=bev)

    def write(self, frame: VideoFrame, prediction: GroundMaps) -> None:  # noqa: ARG002 - `Sink`
        self._file.write(self._overlay.draw(prediction))

    def close(self) -> None:
        self._file.close()


class _JsonLines:
    """Writes each line as soon as its frame is done, so programs can follow the file."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("w", encoding="ascii", buffering=1)

    def write(self, frame: VideoFrame, prediction: GroundMaps) -> None:
        facts = summarise(prediction)
        line = {"frame": frame.index, "time_s": round(frame.time_s, 4)}
        line |= {key: facts[key] for key in _PER_FRAME_KEYS}
        self._file.write(json.dumps(line) + "\n")

    def close(self) -> None:
        self._file.close()
