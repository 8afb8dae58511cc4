"""Recordings of the iOS app Stray Scanner.

``rgb.mp4``, ``depth/000000.png`` (uint16 millimetres, one a frame), ``confidence/000000.png``
(0 to 2), ``camera_matrix.csv`` (3x3, in pixels of the video) and ``odometry.csv`` with the columns
``timestamp, frame, x, y, z, qx, qy, qz, qw``: camera to world, camera axes x right, y down,
z forward of the sensor, which lies on its side when the phone is held upright. The world's y axis
points up.
"""

import csv
import shutil
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.parts import new_part
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.preprocessing import resized
from footprints_edge_models.sample import within
from footprints_edge_models.sequences.camera_files import checked_intrinsics
from footprints_edge_models.sequences.moving_cameras import (
    HAND_HELD,
    numbers_of,
    pose_of_quaternion,
    quarter_turns,
    spread_in_time,
)
from footprints_edge_models.sequences.sequence import (
    DepthPicture,
    Sequence,
    SequenceError,
    SequenceFrame,
    read_raster,
)

LONGEST_SIDE_PX = 1024
"""Frames of the video are kept no larger than this: twice the size of the labels."""
LEAST_CONFIDENCE = 1
"""Depth of low confidence (0) does not count."""

_FRAMES = "frames"
_JPEG_QUALITY = 95
_LAST_FRAME = 10_000_000
_COLUMNS = ("timestamp", "frame", "x", "y", "z", "qx", "qy", "qz", "qw")


@dataclass(frozen=True)
class LidarDepth:
    """A depth picture of the app, turned upright.

    Attributes:
        path: uint16 PNG, millimetres.
        confidence: PNG of 0 to 2, of the same size; it may be missing.
        turns: clockwise quarter turns that stand it upright.
    """

    path: Path
    confidence: Path
    turns: int

    def read(self) -> NDArray[np.float32]:
        """Metres along the optical axis, float32 (H, W), 0 where there is none."""
        depth_m = DepthPicture(self.path).read()
        if self.confidence.is_file():
            confidence = read_raster(self.confidence, "confidence")
            if confidence.shape != depth_m.shape:
                raise SequenceError(f"{self.confidence}: not of the size of {self.path.name}")
            depth_m = np.where(confidence >= LEAST_CONFIDENCE, depth_m, 0)
        return np.ascontiguousarray(np.rot90(depth_m, -self.turns), np.float32)


def is_stray_scanner(folder: Path) -> bool:
    """Whether a folder looks like a recording of the app."""
    return (folder / "odometry.csv").is_file() and (folder / "camera_matrix.csv").is_file()


def read_stray_scanner(folder: Path) -> Sequence:
    """The recording in a folder, ten frames a second, upright.

    The first time, these frames are taken out of the video into ``frames/`` beside it.

    Raises:
        SequenceError: a file is missing or odd, or the video ends early.
    """
    rows = _odometry(folder / "odometry.csv")
    rows = [rows[index] for index in spread_in_time([row["timestamp"] for row in rows])]
    path = folder / "odometry.csv"
    numbers = [_frame_number(row["frame"], path) for row in rows]
    poses = [
        pose_of_quaternion(
            [row[axis] for axis in ("x", "y", "z")],
            [row[axis] for axis in ("qx", "qy", "qz", "qw")],
            f"{path}, frame {number}",
        )
        for row, number in zip(rows, numbers, strict=True)
    ]
    turns = quarter_turns(poses)
    images, size = _unpacked(folder, numbers, turns)
    camera = _turned(_camera(folder / "camera_matrix.csv"), size, turns)
    upright = size if turns % 2 == 0 else size[::-1]
    frames = []
    for time, (number, pose) in enumerate(zip(numbers, poses, strict=True)):
        depth = folder / "depth" / f"{number:06d}.png"
        if not depth.is_file():
            raise SequenceError(f"{depth}: missing; every frame needs its depth")
        frames.append(
            SequenceFrame(
                f"{number:06d}",
                time,
                images[number],
                camera.scaled(upright, within(upright, LONGEST_SIDE_PX)),
                pose @ _quarter_turn(turns),
                LidarDepth(depth, folder / "confidence" / depth.name, turns),
            )
        )
    return Sequence(folder.resolve().name, tuple(frames), HAND_HELD, up=(0.0, 1.0, 0.0))


def _odometry(path: Path) -> list[dict[str, float]]:
    try:
        with path.open(encoding="utf-8", newline="") as file:
            table = list(csv.reader(file, skipinitialspace=True))
    except (OSError, ValueError) as error:
        raise SequenceError(f"{path}: not readable ({error})") from error
    header = [word.strip() for word in table[0]] if table else []
    if missing := [column for column in _COLUMNS if column not in header]:
        raise SequenceError(
            f"{path}: no column {', '.join(missing)}; record again with a newer version of the app"
        )
    rows = []
    for line in filter(None, table[1:]):
        if len(line) < len(header):
            raise SequenceError(f"{path}: the line {','.join(line)!r} is cut off")
        named = dict(zip(header, line, strict=False))
        values = numbers_of([named[column] for column in _COLUMNS], str(path))
        rows.append(dict(zip(_COLUMNS, values, strict=True)))
    if not rows:
        raise SequenceError(f"{path}: no frames here")
    return sorted(rows, key=lambda row: row["timestamp"])


def _frame_number(stated: float, path: Path) -> int:
    if not 0 <= stated <= _LAST_FRAME:
        raise SequenceError(f"{path}: {stated:g} is no frame number")
    return int(stated)


def _camera(path: Path) -> Intrinsics:
    try:
        return checked_intrinsics(np.loadtxt(path, delimiter=","), str(path))
    except (OSError, ValueError) as error:
        raise SequenceError(f"{path}: no readable 3x3 matrix ({error})") from error


def _quarter_turn(turns: int) -> NDArray[np.float64]:
    """(4, 4), from axes of the upright camera to the sensor's."""
    once = np.array([[0.0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    return np.linalg.matrix_power(once, turns)


def _turned(camera: Intrinsics, size: tuple[int, int], turns: int) -> Intrinsics:
    """The camera of a picture (H, W) after clockwise quarter turns."""
    for _ in range(turns):
        camera = Intrinsics(camera.fy, camera.fx, size[0] - 1 - camera.cy, camera.cx)
        size = size[::-1]
    return camera


def _unpacked(
    folder: Path, numbers: list[int], turns: int
) -> tuple[dict[int, Path], tuple[int, int]]:
    """Frames of the video as upright pictures by number, and the size (H, W) of the video."""
    frames = folder / _FRAMES
    images = {number: frames / f"{number:06d}.jpg" for number in numbers}
    video = cv2.VideoCapture(str(folder / "rgb.mp4"))
    video.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
    try:
        size = (
            int(video.get(cv2.CAP_PROP_FRAME_HEIGHT)),
            int(video.get(cv2.CAP_PROP_FRAME_WIDTH)),
        )
        if not video.isOpened() or min(size) < 1:
            raise SequenceError(f"{folder / 'rgb.mp4'}: no readable video")
        if not all(path.is_file() for path in images.values()):
            _write_frames(video, images, folder, turns)
    finally:
        video.release()
    return images, size


def _write_frames(
    video: cv2.VideoCapture, images: dict[int, Path], folder: Path, turns: int
) -> None:
    """Writes the frames to a folder beside the final one, and renames it."""
    part = new_part(folder)
    try:
        part.mkdir()
    except OSError as error:
        raise SequenceError(
            f"{folder}: frames of the video are kept beside it, and nothing can be written here "
            f"({error}); copy the recording"
        ) from error
    try:
        for number in range(max(images) + 1):
            if not video.grab():
                raise SequenceError(
                    f"{folder / 'rgb.mp4'}: ends at frame {number}, odometry.csv goes on to "
                    f"{max(images)}"
                )
            if number in images:
                bgr = np.asarray(video.retrieve()[1], np.uint8)
                upright = np.ascontiguousarray(np.rot90(bgr, -turns))
                size = within((upright.shape[0], upright.shape[1]), LONGEST_SIDE_PX)
                flags = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
                cv2.imwrite(str(part / images[number].name), resized(upright, size), flags)
        frames = folder / _FRAMES
        shutil.rmtree(frames, ignore_errors=True)
        part.replace(frames)
    finally:
        shutil.rmtree(part, ignore_errors=True)
