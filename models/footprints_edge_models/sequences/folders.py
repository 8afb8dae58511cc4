"""Sequences in folders: RGB-D clips with ``sequence.json``, and rectified stereo clips."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footprints_edge.inputs.image_files import IMAGE_SUFFIXES
from footprints_edge_models.sequences.camera_files import checked_intrinsics, checked_pose
from footprints_edge_models.sequences.sequence import (
    DepthPicture,
    LabelPicture,
    Sequence,
    SequenceError,
    SequenceFrame,
    StereoPair,
)

WALKABLE = (4, 7, 10, 12, 14, 29, 30)
"""Floor, road, grass, sidewalk, earth, rug and field among ADE20K's 31 most frequent classes."""


def is_sequence_folder(folder: Path) -> bool:
    """Whether a folder looks like one that :func:`read_sequence_folder` reads."""
    return (folder / "sequence.json").is_file() or (folder / "image_l").is_dir()


def read_sequence_folder(folder: Path) -> Sequence:
    """The clip in a folder, in either of two layouts.

    RGB-D: ``sequence.json`` (``intrinsics`` 3x3; ``frames`` with ``name`` and ``camera_to_world``
    4x4; optionally ``gravity_direction``), ``images/``, ``depth/*.png`` (uint16 millimetres) and,
    where there are any, ``labels/*.png`` of ADE20K class ids.

    Stereo: ``image_l/`` and ``image_r/``, rectified, ``calib.txt`` (two projection matrices 3x4 in
    a line each) and ``poses.txt`` (a camera-to-world matrix 3x4 a line, one a picture).

    Raises:
        SequenceError: there is neither, or something of the layout is missing or makes no sense.
    """
    if (folder / "sequence.json").is_file():
        return _rgbd(folder)
    if (folder / "image_l").is_dir():
        return _stereo(folder)
    raise SequenceError(
        f"{folder}: no sequence here; it needs sequence.json with images/ and depth/, or image_l/, "
        "image_r/, calib.txt and poses.txt (see CONTRIBUTING.md)"
    )


def _rgbd(folder: Path) -> Sequence:
    path = folder / "sequence.json"
    try:
        stated = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise SequenceError(f"{path}: not readable as JSON ({error})") from error
    if not isinstance(stated, dict) or not isinstance(stated.get("frames"), list):
        raise SequenceError(f"{path}: 'frames' is missing; give a list of names and poses")
    if not str(stated.get("depth_unit", "mm")).lower().startswith(("mm", "millimet")):
        raise SequenceError(f"{path}: depth_unit {stated['depth_unit']!r}; save depth in mm")
    camera = checked_intrinsics(stated.get("intrinsics"), str(path))
    images = _pictures(folder / "images")
    frames = []
    for time, entry in enumerate(stated["frames"]):
        name = _frame_name(entry, time, path)
        if "camera_to_world" not in entry:
            raise SequenceError(f"{path}: frame {name} has no pose; give camera_to_world, 4x4")
        if name not in images:
            raise SequenceError(f"{folder / 'images'}: no picture named {name}")
        depth, labels = folder / "depth" / f"{name}.png", folder / "labels" / f"{name}.png"
        if not depth.is_file():
            raise SequenceError(f"{depth}: missing; every frame needs its depth")
        frames.append(
            SequenceFrame(
                name,
                time,
                images[name],
                camera,
                checked_pose(entry["camera_to_world"], f"{path}, frame {name}"),
                DepthPicture(depth),
                LabelPicture(labels, WALKABLE) if labels.is_file() else None,
            )
        )
    _refuse_twins(frames, path)
    return Sequence(folder.resolve().name, tuple(frames), up=_up(stated, path))


def _stereo(folder: Path) -> Sequence:
    calibration = _numbers(folder / "calib.txt")
    if calibration.size != 24:
        raise SequenceError(
            f"{folder / 'calib.txt'}: two projection matrices 3x4 are needed, 24 numbers, not "
            f"{calibration.size}"
        )
    left, right = calibration.reshape(2, 3, 4)
    camera = checked_intrinsics(left[:, :3], str(folder / "calib.txt"))
    baseline_m = float(left[0, 3] / left[0, 0] - right[0, 3] / right[0, 0])
    if not baseline_m > 0:
        raise SequenceError(
            f"{folder / 'calib.txt'}: the second camera stands {baseline_m:g} m to the right of "
            "the first; it must stand to its right"
        )
    images, others = _pictures(folder / "image_l"), _pictures(folder / "image_r")
    poses = np.atleast_2d(_numbers(folder / "poses.txt"))
    if len(poses) != len(images):
        raise SequenceError(
            f"{folder / 'poses.txt'}: {len(poses)} poses for {len(images)} pictures; give one a "
            "line, in the order of the pictures' names"
        )
    frames = []
    for time, (name, image) in enumerate(images.items()):
        if name not in others:
            raise SequenceError(f"{folder / 'image_r'}: no picture named {name}")
        pose = checked_pose(poses[time], f"{folder / 'poses.txt'}, line {time + 1}")
        depth = StereoPair(image, others[name], camera.fx * baseline_m)
        frames.append(SequenceFrame(name, time, image, camera, pose, depth))
    # The world is the first camera's: y points down as nearly as that camera stood level.
    return Sequence(folder.resolve().name, tuple(frames), up=(0.0, -1.0, 0.0))


def _frame_name(entry: object, index: int, path: Path) -> str:
    name = entry.get("name") if isinstance(entry, dict) else None
    if not isinstance(name, str) or not name:
        raise SequenceError(f"{path}: frame number {index} has no name")
    if Path(name).is_absolute() or ".." in Path(name).parts:
        raise SequenceError(f"{path}: the frame name {name!r} leaves the folder; use a plain name")
    return name


def _refuse_twins(frames: list[SequenceFrame], path: Path) -> None:
    seen = set()
    for frame in frames:
        if frame.name in seen:
            raise SequenceError(f"{path}: the frame {frame.name} is there more than once")
        seen.add(frame.name)


def _up(stated: dict[str, Any], path: Path) -> tuple[float, float, float]:
    try:
        x, y, z = (-float(value) for value in stated.get("gravity_direction", (0, -1, 0)))
    except (TypeError, ValueError, OverflowError) as error:
        raise SequenceError(f"{path}: gravity_direction must be three numbers") from error
    if not 0 < math.hypot(x, y, z) < math.inf:
        raise SequenceError(f"{path}: gravity_direction {(-x, -y, -z)} is no direction")
    return x, y, z


def _pictures(folder: Path) -> dict[str, Path]:
    """The pictures of a folder by their names without suffix, sorted."""
    if not folder.is_dir():
        raise SequenceError(f"{folder}: no such folder")
    found = sorted(path for path in folder.iterdir() if path.suffix.lower() in IMAGE_SUFFIXES)
    return {path.stem: path for path in found}


def _numbers(path: Path) -> NDArray[np.float64]:
    try:
        return np.loadtxt(path)
    except (OSError, ValueError) as error:
        raise SequenceError(f"{path}: no readable numbers ({error})") from error
