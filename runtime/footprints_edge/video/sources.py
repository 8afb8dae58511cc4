"""Names of videos: file suffixes, stream addresses and camera numbers."""

import re
from pathlib import Path

VIDEO_SUFFIXES = frozenset(
    {".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm", ".mpg", ".mpeg", ".ts", ".wmv", ".mjpeg"}
    | {".3gp", ".mts", ".m2ts", ".flv", ".ogv"}
)

CAMERA, STREAMS = "camera:", ("rtsp://", "rtsps://")


def is_video(named: str) -> bool:
    """Whether a command-line argument names a video file, a stream or a camera."""
    return is_live(named) or Path(named).suffix.lower() in VIDEO_SUFFIXES


def is_live(named: str) -> bool:
    """Whether a command-line argument names a stream or a camera."""
    return named.lower().startswith((CAMERA, *STREAMS))


def without_password(named: str) -> str:
    """The name as it may be printed: of a stream without its user, password and keys."""
    if not named.lower().startswith(STREAMS):
        return named
    scheme, _, address = named.partition("://")
    user, at, place = address.rpartition("@")
    shown = f"***@{place}" if at and user else address
    return f"{scheme}://" + re.sub(
        r"(?i)([?&][^=&]*(?:pass|pwd|key|token)[^=&]*=)[^&]*", r"\1***", shown
    )
