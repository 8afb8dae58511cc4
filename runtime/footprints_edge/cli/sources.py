"""The pictures that the command line names: files, folders and standard input."""

from dataclasses import dataclass
from pathlib import Path

from footprints_edge.inputs.image_files import image_files
from footprints_edge.outputs.writers import OUTPUT_ENDINGS

STDIN = "-"


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
        """The name that its outputs begin with."""
        return self.path.name if self.path else "stdin"

    @property
    def label(self) -> str:
        """Its name in messages."""
        return str(self.path) if self.path else "standard input"


def expand(named: str, *, recursive: bool = False) -> list[Source]:
    """The pictures that one command-line argument stands for, in order.

    Args:
        named: A file, a folder, or `-` for standard input.
        recursive: Whether a folder's sub-folders count.

    Raises:
        ImageError: If a folder holds no picture. A missing file shows when it is read.
    """
    if named == STDIN:
        return [Source(None)]
    path = Path(named)
    if not path.is_dir():
        return [Source(path)]
    found = image_files(path, recursive=recursive, skip_endings=OUTPUT_ENDINGS)
    return [Source(each, each.parent.relative_to(path)) for each in found]
