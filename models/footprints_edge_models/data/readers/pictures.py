"""The pictures of a folder."""

from pathlib import Path

from footprints_edge.inputs.image_files import IMAGE_SUFFIXES
from footprints_edge_models.data.errors import DatasetError


def list_pictures(folder: Path) -> list[Path]:
    """The pictures of a folder, sorted by name.

    Raises:
        DatasetError: there is no such folder.
    """
    if not folder.is_dir():
        raise DatasetError(f"{folder}: no such folder; see CONTRIBUTING.md for the data layout")
    return sorted(p for p in folder.iterdir() if p.suffix.lower() in IMAGE_SUFFIXES)
