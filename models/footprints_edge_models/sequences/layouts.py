"""Detects the layout of a sequence from its files, and reads it."""

from pathlib import Path

from footprints_edge_models.sequences.colmap_text import is_colmap, read_colmap
from footprints_edge_models.sequences.folders import is_sequence_folder, read_sequence_folder
from footprints_edge_models.sequences.kitti import is_drive, read_kitti_raw
from footprints_edge_models.sequences.matterport import is_scan, read_matterport
from footprints_edge_models.sequences.record3d import is_record3d, read_record3d
from footprints_edge_models.sequences.scannet import is_scannet, read_scannet
from footprints_edge_models.sequences.sequence import Sequence, SequenceError
from footprints_edge_models.sequences.stray_scanner import is_stray_scanner, read_stray_scanner
from footprints_edge_models.sequences.tum_rgbd import is_tum_rgbd, read_tum_rgbd

CLIPS = (
    (is_sequence_folder, read_sequence_folder),
    (is_tum_rgbd, read_tum_rgbd),
    (is_scannet, read_scannet),
    (is_stray_scanner, read_stray_scanner),
    (is_record3d, read_record3d),
    (is_colmap, read_colmap),
)
"""Layouts that a folder shows by itself: whether it has one, and its reader."""


def read_sequence(folder: Path, published: Path | None = None) -> Sequence:
    """Read the sequence in a folder of any supported layout.

    Args:
        folder: a sequence folder (see :mod:`folders`), a clip in the format of TUM RGB-D, an
            exported ScanNet scan, a recording of Stray Scanner or Record3D, a reconstruction of
            COLMAP with depth, a drive of KITTI raw in its place below the date, or a Matterport3D
            scan.
        published: folder or zip of the training data published with the paper, for the latter two.

    Raises:
        SequenceError: it is none of these, not laid out as expected, or cannot be read.
    """
    try:
        return _read(folder.resolve(), published)
    except OSError as error:  # such as a stated name that is too long for a file
        raise SequenceError(f"{folder} cannot be read: {error}") from error


def _read(folder: Path, published: Path | None) -> Sequence:
    for has_layout, read in CLIPS:
        if has_layout(folder):
            return read(folder)
    if is_drive(folder):
        drive = f"{folder.parent.name}/{folder.name}"
        return read_kitti_raw(folder.parents[1], drive, published)
    if is_scan(folder):
        scans = folder.parents[1] if folder.parent.name == folder.name else folder.parent
        return read_matterport(scans, folder.name, published)
    raise SequenceError(
        f"{folder}: no sequence here; it is a folder with sequence.json, one with image_l and "
        "image_r, a TUM RGB-D clip (rgb.txt, groundtruth.txt), a ScanNet scan (color, pose), a "
        "recording of Stray Scanner (odometry.csv), an unpacked .r3d of Record3D (metadata, rgbd), "
        "a COLMAP reconstruction (cameras.txt), a drive of KITTI raw (image_02) or a Matterport3D "
        "scan (matterport_color_images); see docs/labels.md"
    )
