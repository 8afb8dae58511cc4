"""Labels on disk: ``labels.json`` with the settings, and a file per frame.

A frame's file is written atomically, so a frame is done exactly when its file reads.
"""

import io
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import PIL
from PIL import Image

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge.foundation.parts import remove_abandoned
from footprints_edge.foundation.version import __version__
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import decode
from footprints_edge_models.bounded_files import read_arrays
from footprints_edge_models.sequences.sequence import Sequence
from footprints_edge_models.video_labels.labeller import FrameLabels, LabelSettings

ABOUT = "labels.json"
_FORMAT = 1
_JPEG_QUALITY = 95


class LabelFilesError(FootprintsError):
    """A folder of labels belongs to another job, or one of its files is missing or damaged."""


def frame_path(folder: Path, name: str) -> Path:
    """The file of a frame's labels."""
    return folder / "frames" / f"{name}.npz"


def claim(folder: Path, sequence: Sequence, settings: LabelSettings) -> None:
    """Begin a folder for a job, or check that it was begun for the same one.

    Raises:
        LabelFilesError: it holds labels of another sequence, or made with other settings.
    """
    path = folder / ABOUT
    about = {
        "format": _FORMAT,
        "sequence": sequence.name,
        "neighbours": {"kind": type(sequence.neighbours).__name__, **asdict(sequence.neighbours)},
        "least_hits": sequence.least_hits,
        "settings": asdict(settings),
    }
    about = json.loads(json.dumps(about, default=str))  # tuples and paths as JSON knows them
    if not path.exists():
        about["made_with"] = {
            "footprints-edge": __version__,
            "numpy": np.__version__,
            "opencv": cv2.__version__,  # of whichever of its distributions is installed
            "pillow": PIL.__version__,
        }
        write_atomically(path, (json.dumps(about, indent=2) + "\n").encode())
        return
    there = read_about(folder)
    for key, value in _flat(about).items():
        before = _flat(there).get(key)
        if before != value:
            raise LabelFilesError(
                f"{folder} holds labels with {key} = {json.dumps(before)}, now it is "
                f"{json.dumps(value)}; choose another folder, or the same options to resume"
            )


def read_about(folder: Path) -> dict[str, Any]:
    """The contents of ``labels.json``.

    Raises:
        LabelFilesError: it is missing, damaged, or of another format.
    """
    path = folder / ABOUT
    try:
        about = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise LabelFilesError(f"{path}: not readable ({error})") from error
    if not isinstance(about, dict) or about.get("format") != _FORMAT:
        raise LabelFilesError(
            f"{path}: not of the format that this version writes ({_FORMAT}); make the "
            "labels again in another folder"
        )
    return about


def write_frame(folder: Path, labels: FrameLabels) -> None:
    """Write the labels of a frame atomically.

    Depths and probability are float16, right to 0.05 %; the picture is JPEG of quality 95.
    """
    camera = labels.intrinsics
    picture, data = io.BytesIO(), io.BytesIO()
    Image.fromarray(labels.image).save(picture, "JPEG", quality=_JPEG_QUALITY, subsampling=0)
    np.savez_compressed(
        data,
        image=np.frombuffer(picture.getvalue(), np.uint8),
        intrinsics=np.array([camera.fx, camera.fy, camera.cx, camera.cy]),
        ground_probability=labels.ground_probability.astype(np.float16),
        visible_depth_m=labels.visible_depth_m.astype(np.float16),
        ground_depth_m=labels.ground_depth_m.astype(np.float16),
        untraversable=labels.footprint_mask,
        moving=labels.moving,
    )
    write_atomically(frame_path(folder, labels.name), data.getvalue())


def read_frame(folder: Path, name: str) -> FrameLabels:
    """The labels of a frame.

    Raises:
        LabelFilesError: they are missing or damaged.
    """
    path = frame_path(folder, name)
    try:
        arrays = read_arrays(path)
        return FrameLabels(
            name,
            decode(arrays["image"].tobytes()).rgb,
            Intrinsics(*arrays["intrinsics"].tolist()),
            arrays["ground_probability"].astype(np.float32),
            arrays["visible_depth_m"].astype(np.float32),
            arrays["ground_depth_m"].astype(np.float32),
            arrays["untraversable"],
            arrays["moving"],
        )
    except (OSError, KeyError, ValueError, TypeError, FootprintsError) as error:
        raise LabelFilesError(f"{path}: no readable labels ({error})") from error


def frame_names(folder: Path) -> list[str]:
    """The names of the frames that have a file, sorted."""
    frames = folder / "frames"
    return sorted(p.relative_to(frames).with_suffix("").as_posix() for p in frames.rglob("*.npz"))


def remove_fragments(folder: Path) -> None:
    """Remove files that killed processes of this machine left half written."""
    for each in {path.parent for path in folder.rglob(".*.part")}:
        remove_abandoned(each)


def _flat(values: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested keys joined by dots, so that a message can name the one that differs."""
    flat: dict[str, Any] = {}
    for key, value in values.items():
        if isinstance(value, dict):
            flat |= _flat(value, f"{prefix}{key}.")
        else:
            flat[prefix + key] = value
    return flat
