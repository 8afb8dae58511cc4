"""Clips in the format of the TUM RGB-D benchmark.

``rgb.txt`` and ``depth.txt`` list a time stamp and a file a line, ``groundtruth.txt`` a time stamp,
a position in metres and a quaternion x y z w, camera to world. Depth pictures hold 5000 units a
metre and are registered with the colour pictures. The world's z axis points up, as that of the
benchmark's motion capture does. ``calibration.txt``, ours, holds ``fx fy cx cy`` where the camera
is not a Kinect.
"""

from pathlib import Path

import numpy as np
from PIL import Image

from footprints_edge.errors import IntrinsicsError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.sequences.moving_cameras import (
    HAND_HELD,
    numbers_of,
    pose_of_quaternion,
    read_lines,
    spread_in_time,
)
from footprints_edge_models.sequences.sequence import (
    DepthPicture,
    Sequence,
    SequenceError,
    SequenceFrame,
)

KINECT = Intrinsics(525.0, 525.0, 319.5, 239.5)
"""The camera that the benchmark recommends for its pictures of 640x480."""
METRES_PER_UNIT = 1 / 5000
MOST_APART_S = 0.02
"""Time stamps farther apart than this do not belong together; as the benchmark's own scripts."""

_KINECT_WH = (640, 480)


def is_tum_rgbd(folder: Path) -> bool:
    """Whether a folder looks like a clip in this format."""
    return (folder / "rgb.txt").is_file() and (folder / "groundtruth.txt").is_file()


def read_tum_rgbd(folder: Path) -> Sequence:
    """The clip in a folder: colour pictures with a depth picture and a pose of the same time.

    Raises:
        SequenceError: a list is missing or odd, or nothing belongs together.
    """
    images, depths = (_stamped(folder / name) for name in ("rgb.txt", "depth.txt"))
    poses = _stamped(folder / "groundtruth.txt")
    frames: list[SequenceFrame] = []
    camera = None
    for index in spread_in_time([time_s for time_s, _ in images]):
        time_s, image = images[index][0], images[index][1][0]
        depth, pose = _nearest(depths, time_s), _nearest(poses, time_s)
        if depth is None or pose is None:
            continue
        path = _existing(folder, image)
        camera = camera or _camera(folder, path)
        where = f"{folder / 'groundtruth.txt'}, time {time_s:.4f}"
        values = numbers_of(pose, where)
        if len(values) != 7:
            raise SequenceError(f"{where}: tx ty tz qx qy qz qw are needed, not {len(values)}")
        frames.append(
            SequenceFrame(
                Path(image).stem,
                len(frames),
                path,
                camera,
                pose_of_quaternion(values[:3], values[3:], where),
                DepthPicture(_existing(folder, depth[0]), METRES_PER_UNIT),
            )
        )
    if not frames:
        raise SequenceError(
            f"{folder}: no picture has both depth and a pose within {MOST_APART_S} s; are the "
            "three lists of the same recording?"
        )
    return Sequence(folder.resolve().name, tuple(frames), HAND_HELD, up=(0.0, 0.0, 1.0))


def _stamped(path: Path) -> list[tuple[float, list[str]]]:
    """Time stamps in seconds and the words after them, in order of time."""
    entries = []
    for line in read_lines(path):
        words = line.replace(",", " ").split()
        if len(words) > 1:
            entries.append((numbers_of(words[:1], str(path))[0], words[1:]))
    if not entries:
        raise SequenceError(f"{path}: no time stamps here")
    return sorted(entries, key=lambda entry: entry[0])


def _nearest(entries: list[tuple[float, list[str]]], time_s: float) -> list[str] | None:
    times_s = np.array([entry[0] for entry in entries])
    nearest = int(np.abs(times_s - time_s).argmin())
    return entries[nearest][1] if abs(times_s[nearest] - time_s) <= MOST_APART_S else None


def _existing(folder: Path, name: str) -> Path:
    path = folder / name
    if not path.is_file():
        raise SequenceError(f"{path}: no such file, but the lists name it")
    return path


def _camera(folder: Path, image: Path) -> Intrinsics:
    path = folder / "calibration.txt"
    if path.is_file():
        values = numbers_of(" ".join(read_lines(path)).split(), str(path))
        try:
            fx, fy, cx, cy = values[:4]
            return Intrinsics(fx, fy, cx, cy)
        except (ValueError, IntrinsicsError) as error:
            raise SequenceError(f"{path}: 'fx fy cx cy' in pixels are needed ({error})") from error
    try:
        with Image.open(image) as opened:
            size = opened.size
    except Exception as error:  # Pillow's decoders raise almost anything on damaged files
        raise SequenceError(f"{image}: no readable picture ({error})") from error
    if size != _KINECT_WH:
        raise SequenceError(
            f"{image}: {size[0]}x{size[1]} pixels, not a Kinect's 640x480; write 'fx fy cx cy' in "
            f"pixels to {path}"
        )
    return KINECT
