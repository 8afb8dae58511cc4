"""Detects the layout of a sequence from its files, and reads it."""

from pathlib import Path

from footprints_edge_models.sequences.folders import is_sequence_folder, read_sequence_folder
from footprints_edge_models.sequences.kitti import is_drive, read_kitti_raw
from footprints_edge_models.sequences.matterport import is_scan, read_matterport
from footprints_edge_models.sequences.sequence import Sequence, SequenceError


def read_sequence(folder: Path, published: Path | None = None) -> Sequence:
    """Read the sequence in a folder of any supported layout.

    Args:
        folder: a sequence folder (see :mod:`folders`), a drive of KITTI raw in its place
            below the date, or a Matterport3D scan.
        published: folder or zip of the training data published with the paper, for the latter two.

    Raises:
        SequenceError: it is none of these, or not laid out as expected.
    """
    folder = folder.resolve()
    if is_sequence_folder(folder):
        return read_sequence_folder(folder)
    if is_drive(folder):
        drive = f"{folder.parent.name}/{folder.name}"
        return read_kitti_raw(folder.parents[1], drive, published)
    if is_scan(folder):
        scans = folder.parents[1] if folder.parent.name == folder.name else folder.parent
        return read_matterport(scans, folder.name, published)
    raise SequenceError(
        f"{folder}: no sequence here; it is a folder with sequence.json, one with image_l and "
        "image_r, a drive of KITTI raw (with image_02) or a Matterport3D scan (with "
        "matterport_color_images); see CONTRIBUTING.md"
    )
