"""What the command line names - files, folders, standard input, videos - and what kind it is."""

from dataclasses import dataclass
from pathlib import Path

from footprints_edge.errors import ImageError
from footprints_edge.outputs.writers import FORMATS

STDIN = "-"

SUFFIXES = frozenset({".jpg", ".jpeg", ".png", ".webp", ".tif", ".tiff", ".bmp"})
"""What counts as a picture in a folder. A file that is named outright is always tried."""

VIDEO_SUFFIXES = frozenset(
    {".mp4", ".m4v", ".mov", ".avi", ".mkv", ".webm", ".mpg", ".mpeg", ".ts", ".wmv", ".mjpeg"}
)

CAMERA, STREAMS = "camera:", ("rtsp://", "rtsps://")

_OUR_SUFFIXES = tuple(suffix for files in FORMATS.values() for suffix in files)


@dataclass(frozen=True)
class Source:
    """One picture to read.

    Attributes:
        path: Its file; None means standard input.
        subfolder: Where it lies below the folder that was named; `.` for a file named outright.
    """

    path: Path | None
    subfolder: Path = Path()

    @property
    def name(self) -> str:
        """What its outputs are named after."""
        return self.path.name if self.path else "stdin"

    @property
    def label(self) -> str:
        """How messages call it."""
        return str(self.path) if self.path else "standard input"


def is_video(named: str) -> bool:
    """Whether an argument of the command line names a video, a stream or a camera."""
    return named.startswith((CAMERA, *STREAMS)) or Path(named).suffix.lower() in VIDEO_SUFFIXES


def expand(named: str, *, recursive: bool = False) -> list[Source]:
    """The pictures that one argument of the command line stands for, in order.

    Args:
        named: A file, a folder, or `-` for standard input.
        recursive: Whether a folder's sub-folders count.

    Raises:
        ImageError: If a folder holds no picture. A missing file shows when it is read.
    """
    if named == STDIN:
        return [Source(None)]
    path = Path(named)
    return _pictures(path, recursive) if path.is_dir() else [Source(path)]


def _pictures(folder: Path, recursive: bool) -> list[Source]:
    """A folder's pictures, sorted; neither hidden files nor what an earlier run made of them."""
    found = [
        path
        for path in sorted(folder.rglob("*") if recursive else folder.iterdir())
        if path.suffix.lower() in SUFFIXES
        and not path.name.startswith(".")
        and not path.name.lower().endswith(_OUR_SUFFIXES)
        and path.is_file()
    ]
    if not found:
        hint = "" if recursive else "; --recursive looks in its sub-folders too"
        raise ImageError(
            f"{folder}: no picture in this folder ({', '.join(sorted(SUFFIXES))}){hint}"
        )
    return [Source(path, path.parent.relative_to(folder)) for path in found]
