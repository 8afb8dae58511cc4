"""Names of videos: file suffixes, stream addresses and camera numbers."""

from pathlib import Path

VIDEO_SUFFIXES = frozenset(
    {".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm", ".mpg", ".mpeg", ".ts", ".wmv", ".mjpeg"}
)

CAMERA, STREAMS = "camera:", ("rtsp://", "rtsps://")


def is_video(named: str) -> bool:
    """Whether a command-line argument names a video file, a stream or a camera."""
    return named.startswith((CAMERA, *STREAMS)) or Path(named).suffix.lower() in VIDEO_SUFFIXES
