"""Recordings of the iOS app Record3D, its ``.r3d`` files unpacked.

``metadata`` is JSON: ``w`` and ``h``, the pictures' size; ``K``, the camera's matrix by columns;
``poses``, a row ``qx, qy, qz, qw, x, y, z`` a frame, camera to world, camera axes x right, y up,
z backward; ``frameTimestamps`` in seconds, or ``fps``. ``rgbd/0.jpg``, ``0.depth`` (float32 metres)
and ``0.conf`` (0 to 2) follow for each frame, the last two compressed by Apple's LZFSE. The world's
y axis points up.
"""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footprints_edge.inputs.images import MAX_PIXELS
from footprints_edge_models.sequences.camera_files import checked_intrinsics
from footprints_edge_models.sequences.moving_cameras import (
    HAND_HELD,
    pose_of_quaternion,
    quarter_turns,
    spread_in_time,
)
from footprints_edge_models.sequences.sequence import Sequence, SequenceError, SequenceFrame

LEAST_CONFIDENCE = 1
"""Depth of low confidence (0) does not count."""

_FLIP = np.diag([1.0, -1.0, -1.0, 1.0])
"""From camera axes x right, y down, z forward to the app's."""


@dataclass(frozen=True)
class CompressedDepth:
    """A depth picture of the app.

    Attributes:
        path: float32 metres, compressed.
        confidence: 0 to 2, compressed; it may be missing.
        picture: (H, W) of the picture, whose aspect depth has, too.
    """

    path: Path
    confidence: Path
    picture: tuple[int, int]

    def read(self) -> NDArray[np.float32]:
        """Metres along the optical axis, float32 (h, w), 0 where there is none."""
        depth_m = self._values(self.path, np.float32)
        if self.confidence.is_file():
            confidence = self._values(self.confidence, np.uint8)
            if confidence.shape != depth_m.shape:
                raise SequenceError(f"{self.confidence}: not of the size of {self.path.name}")
            depth_m = np.where(confidence >= LEAST_CONFIDENCE, depth_m, 0)
        return np.asarray(np.nan_to_num(depth_m, nan=0, posinf=0, neginf=0), np.float32)

    def _values(self, path: Path, kind: type[np.generic]) -> NDArray[Any]:
        height, width = self.picture
        most = height * width * np.dtype(kind).itemsize  # depth is no finer than the picture
        try:
            values = np.frombuffer(_unpacked(path.read_bytes(), most), kind)
        except (OSError, ValueError) as error:
            raise SequenceError(f"{path}: not readable ({error})") from error
        rows = round(math.sqrt(len(values) * height / width))
        if rows < 1 or rows * round(rows * width / height) != len(values):
            raise SequenceError(
                f"{path}: {len(values)} values are no picture of {height}x{width}'s aspect"
            )
        return values.reshape(rows, -1)


def is_record3d(folder: Path) -> bool:
    """Whether a folder looks like an unpacked recording of the app."""
    return (folder / "metadata").is_file() and (folder / "rgbd").is_dir()


def read_record3d(folder: Path) -> Sequence:
    """The recording in a folder, ten frames a second.

    Raises:
        SequenceError: a file is missing or odd, or the phone lay on its side.
    """
    path = folder / "metadata"
    try:
        about = json.loads(path.read_text(encoding="utf-8"))
        size = (int(about["h"]), int(about["w"]))
        matrix = np.asarray(about["K"], np.float64).reshape(3, 3).T
        rows = [[float(value) for value in row] for row in about["poses"]]
        times_s = [float(value) for value in about.get("frameTimestamps") or ()]
        if len(times_s) != len(rows):
            times_s = [number / float(about["fps"]) for number in range(len(rows))]
    except (
        *(OSError, ValueError, KeyError, TypeError),
        *(ArithmeticError, RecursionError),  # an infinite size, 0 fps; deep JSON
    ) as error:
        raise SequenceError(f"{path}: no readable metadata of Record3D ({error!r})") from error
    if not rows or {len(row) for row in rows} != {7} or min(size) < 1:
        raise SequenceError(f"{path}: a size and seven numbers a pose are needed")
    if math.prod(size) > MAX_PIXELS:
        raise SequenceError(f"{path}: pictures of {size[1]:.4g} x {size[0]:.4g} pixels")
    camera = checked_intrinsics(matrix, str(path))
    frames = []
    for time, number in enumerate(spread_in_time(times_s)):
        image = folder / "rgbd" / f"{number}.jpg"
        depth = image.with_suffix(".depth")
        for file in (image, depth):
            if not file.is_file():
                raise SequenceError(f"{file}: missing; metadata lists {len(rows)} frames")
        *rotation, x, y, z = rows[number]
        pose = pose_of_quaternion([x, y, z], rotation, f"{path}, frame {number}") @ _FLIP
        frames.append(
            SequenceFrame(
                f"{number:06d}",
                time,
                image,
                camera,
                pose,
                CompressedDepth(depth, image.with_suffix(".conf"), size),
            )
        )
    if quarter_turns([frame.camera_to_world for frame in frames]):
        raise SequenceError(f"{folder}: recorded with the phone on its side; hold it upright")
    return Sequence(folder.resolve().name, tuple(frames), HAND_HELD, up=(0.0, 1.0, 0.0))


def _unpacked(content: bytes, most: int) -> bytes:
    """Decompressed bytes; LZFSE packs a hundred megabytes of zeros into some kilobytes.

    Raises:
        SequenceError: the library is missing.
        ValueError: they are damaged, or more than `most`.
    """
    try:
        from imagecodecs import LzfseError, lzfse_decode
    except ImportError:
        raise SequenceError(
            "depth of Record3D is compressed by LZFSE: pip install imagecodecs, or export from "
            "the app in another format"
        ) from None
    try:
        unpacked = bytes(lzfse_decode(content, out=most + 1))
    except LzfseError as error:
        raise ValueError(f"no LZFSE: {error}") from error
    if len(unpacked) > most:
        raise ValueError(f"it unpacks to more than {most} bytes, its picture's")
    return unpacked
