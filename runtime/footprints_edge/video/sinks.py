"""What a video becomes: an overlay video, and a line of JSON for each frame."""

import json
from collections.abc import Sequence
from pathlib import Path

from footprints_edge.errors import OutputError
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.outputs.json_summary import summarise
from footprints_edge.video.capture import Frame, VideoFile
from footprints_edge.video.overlay import VideoOverlay
from footprints_edge.video.pipeline import Sink

SUFFIXES = {"overlay": ".overlay.mp4", "json": ".jsonl"}
"""The formats that a video can have, and what each adds to its name."""

_EACH_FRAME = ("ground_fraction", "ground_distance_m", "timings_ms")
"""What of the `json` output a line holds: the rest is the same in all frames."""


def video_paths(folder: Path, name: str, formats: Sequence[str]) -> dict[str, Path]:
    """The file of each format, in order.

    Raises:
        OutputError: If a video cannot have one of the formats.
    """
    unknown = [key for key in formats if key not in SUFFIXES]
    if unknown or not formats:
        raise OutputError(
            f"a video has no format {', '.join(unknown) or '(none given)'}; "
            f"choose from {', '.join(SUFFIXES)}"
        )
    return {key: folder / (name + SUFFIXES[key]) for key in formats}


def open_sinks(paths: dict[str, Path], fps: float, *, bev: bool = False) -> list[Sink]:
    """What writes the files of `video_paths`.

    Args:
        paths: Of each format.
        fps: Frames a second.
        bev: Whether the overlay has a bird's-eye view beside it.

    Raises:
        OutputError: If a file cannot be begun.
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

    def write(self, frame: Frame, prediction: GroundMaps) -> None:  # noqa: ARG002 - a sink's
        self._file.write(self._overlay.draw(prediction))

    def close(self) -> None:
        self._file.close()


class _JsonLines:
    """Each line is there as soon as its frame is done: a file to follow."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("w", encoding="ascii", buffering=1)

    def write(self, frame: Frame, prediction: GroundMaps) -> None:
        facts = summarise(prediction)
        line = {"frame": frame.index, "time_s": round(frame.time_s, 4)}
        line |= {key: facts[key] for key in _EACH_FRAME}
        self._file.write(json.dumps(line) + "\n")

    def close(self) -> None:
        self._file.close()
