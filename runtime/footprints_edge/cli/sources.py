"""Input pictures of the command line: files, folders and standard input."""

from dataclasses import dataclass
from pathlib import Path

from footprints_edge.errors import ImageError
from footprints_edge.foundation.addresses import is_address, without_password
from footprints_edge.inputs.image_files import image_files, passed_over, readable_suffixes
from footprints_edge.outputs.writers import OUTPUT_ENDINGS
from footprints_edge.video.sources import STDIN, is_video


@dataclass(frozen=True)
class InputImage:
    """One picture to read.

    Attributes:
        path: The file; None means standard input.
        subfolder: Path of its folder relative to the given folder; `.` for a file given directly.
    """

    path: Path | None
    subfolder: Path = Path()

    @property
    def name(self) -> str:
        """Prefix of the names of its outputs."""
        return self.path.name if self.path else "stdin"

    @property
    def label(self) -> str:
        """Name for messages."""
        return str(self.path) if self.path else "standard input"


def expand(named: str, *, recursive: bool = False) -> list[InputImage]:
    """Expands one command-line argument to pictures, in order.

    Args:
        named: A file, a folder, or `-` for standard input.
        recursive: Whether to search a folder's sub-folders too.

    Raises:
        ImageError: If a folder contains no pictures, or the argument is an address. A missing file
            fails later, when it is read.
    """
    if named == STDIN:
        return [InputImage(None)]
    path = Path(named)
    if is_address(named):
        raise ImageError(
            f"{without_password(named)} is an address; download the picture first, or for a stream "
            "give rtsp:// or rtsps://"
        )
    if not path.is_dir():
        return [InputImage(path)]
    found = image_files(path, recursive=recursive, skip_endings=OUTPUT_ENDINGS)
    return [InputImage(each, each.parent.relative_to(path)) for each in found]


def left_out(named: str, *, recursive: bool = False) -> str:
    """Says which pictures and videos of a folder `expand` leaves out; empty if there are none."""
    path = Path(named)
    if not path.is_dir():
        return ""
    kinds = passed_over(path, recursive=recursive)
    said = [f"passed over {kinds}, which cannot be read here"] if kinds else []
    found = path.rglob("*") if recursive else path.iterdir()
    if count := sum(map(_is_shown_video, found)):
        said.append(f"videos beside pictures are done only by name: {count}")
    return f"{named}: {'; '.join(said)}" if said else ""


def folder_of_videos(named: str, *, recursive: bool = False) -> list[str]:
    """The videos of a folder that has videos and no pictures, in order; else the argument itself.

    Our own overlays are not among them.
    """
    path = Path(named)
    try:
        if is_video(named) or not path.is_dir():
            return [named]
        files = sorted(path.rglob("*") if recursive else path.iterdir())
        shown = [each for each in files if not each.name.startswith(".") and each.is_file()]
    except OSError:  # said when it is read
        return [named]
    if any(each.suffix.lower() in readable_suffixes() for each in shown):
        return [named]
    return [str(each) for each in shown if _is_shown_video(each)] or [named]


def _is_shown_video(path: Path) -> bool:
    """Whether a file of a folder is a video, and none of our own overlays."""
    is_ours = path.name.startswith(".") or path.name.endswith(".overlay.mp4")
    return not is_ours and is_video(str(path)) and path.is_file()
