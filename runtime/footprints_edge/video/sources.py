"""Names of videos: file suffixes, stream addresses and camera numbers."""

from pathlib import Path

VIDEO_SUFFIXES = frozenset(
    {".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm", ".mpg", ".mpeg", ".ts", ".wmv", ".mjpeg"}
    | {".3gp", ".mts", ".m2ts", ".flv", ".ogv"}
)

STDIN = "-"
"""Standard input, for pictures as for raw frames."""

CAMERA, STREAMS = "camera:", ("rtsp://", "rtsps://")


def is_video(named: str) -> bool:
    """Whether a command-line argument names a video file, a stream or a camera."""
    return is_live(named) or Path(named).suffix.lower() in VIDEO_SUFFIXES


def is_live(named: str) -> bool:
    """Whether a command-line argument names a stream or a camera."""
    return named.lower().startswith((CAMERA, *STREAMS))
