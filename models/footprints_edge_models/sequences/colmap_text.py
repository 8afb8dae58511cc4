"""Reconstructions of COLMAP in text form, with depth.

``cameras.txt`` and ``images.txt`` in the folder, in ``sparse/`` or in ``sparse/0/``; pictures in
``images/``; depth in ``depth/STEM.png`` (uint16 millimetres) or as COLMAP's own
``stereo/depth_maps/NAME.geometric.bin``. COLMAP does not know the scale: its world must have been
brought to metres. Which way is up is taken from the cameras: they are held level, if not straight.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.sequences.camera_files import checked_intrinsics, checked_pose
from footprints_edge_models.sequences.moving_cameras import (
    numbers_of,
    pose_of_quaternion,
    read_lines,
)
from footprints_edge_models.sequences.sequence import (
    DepthPicture,
    InSpace,
    LazyArray,
    Sequence,
    SequenceError,
    SequenceFrame,
)

NEAR = InSpace((5.0, 5.0, 5.0))
"""Pictures need not be in the order of a video: neighbours are the cameras within 5 m."""

_Y_SHARE = 0.01
_PLACES = (".", "sparse", "sparse/0")
_PARAMETERS = {
    "SIMPLE_PINHOLE": (0, 0, 1, 2),
    "PINHOLE": (0, 1, 2, 3),
    "SIMPLE_RADIAL": (0, 0, 1, 2),
    "RADIAL": (0, 0, 1, 2),
    "OPENCV": (0, 1, 2, 3),
    "FULL_OPENCV": (0, 1, 2, 3),
}
"""Of each camera model, which parameters are fx, fy, cx and cy; what follows them is distortion."""


@dataclass(frozen=True)
class ColmapDepth:
    """A depth map of COLMAP's dense reconstruction: ``W&H&1&`` and float32, in row-major order."""

    path: Path

    def read(self) -> NDArray[np.float32]:
        """Depth along the optical axis, float32 (H, W), 0 where there is none."""
        try:
            content = self.path.read_bytes()
            width, height, channels, values = content.split(b"&", 3)
            size = int(height), int(width)
            depth = np.frombuffer(values, "<f4").reshape(size)
            if int(channels) != 1:
                raise ValueError(f"{int(channels)} channels")
        except (OSError, ValueError) as error:
            raise SequenceError(f"{self.path}: no readable depth map ({error})") from error
        return np.where(np.isfinite(depth) & (depth > 0), depth, 0).astype(np.float32)


def is_colmap(folder: Path) -> bool:
    """Whether a folder looks like a reconstruction, in text or binary form."""
    return _model(folder, "txt") is not None or _model(folder, "bin") is not None


def read_colmap(folder: Path) -> Sequence:
    """The reconstruction in a folder: pictures that were placed and have depth.

    Raises:
        SequenceError: it is in binary form, its pictures are distorted, or a file is missing.
    """
    model = _model(folder, "txt")
    if model is None:
        raise SequenceError(
            f"{folder}: the reconstruction is in binary form; write it as text: colmap "
            "model_converter --output_type TXT"
        )
    cameras = _cameras(model / "cameras.txt")
    path = model / "images.txt"
    frames: list[SequenceFrame] = []
    # two lines a picture; the second, its points, may be empty
    for line in sorted(filter(str.strip, read_lines(path)[::2]), key=lambda line: line.split()[-1]):
        words = line.split(maxsplit=9)
        if len(words) != 10:
            raise SequenceError(f"{path}: {line!r} is not 'ID QW QX QY QZ TX TY TZ CAMERA NAME'")
        name, where = words[9], f"{path}, {words[9]}"
        if Path(name).is_absolute() or ".." in Path(name).parts:
            raise SequenceError(f"{path}: the name {name!r} leaves the folder of pictures")
        w, x, y, z, *shift = numbers_of(words[1:8], where)
        if words[8] not in cameras:
            raise SequenceError(f"{where}: camera {words[8]} is not in cameras.txt")
        image = folder / "images" / name
        if not image.is_file():
            raise SequenceError(f"{image}: no such picture, but {path.name} names it")
        to_world = checked_pose(
            np.linalg.inv(pose_of_quaternion(shift, (x, y, z, w), where)), where
        )
        depth = _depth(folder, name)
        frames.append(
            SequenceFrame(
                str(Path(name).with_suffix("")),
                len(frames),
                image,
                cameras[words[8]],
                to_world,
                depth,
            )
        )
    if not frames:
        raise SequenceError(f"{path}: no pictures here")
    up = _up(np.stack([frame.camera_to_world[:3, :3] for frame in frames]))
    return Sequence(folder.resolve().name, tuple(frames), NEAR, up=up)


def _up(rotations: NDArray[np.float64]) -> tuple[float, float, float]:
    """The direction at right angles to most cameras' x axes, by rotations (N, 3, 3).

    Where all cameras look the same way, the one of these that is nearest to their y axes.
    """
    right, down = rotations[:, :, 0], rotations[:, :, 1]
    _, directions = np.linalg.eigh(right.T @ right - _Y_SHARE * down.T @ down)
    up = directions[:, 0]
    x, y, z = (-up if up @ down.mean(axis=0) > 0 else up).tolist()
    return x, y, z


def _model(folder: Path, form: str) -> Path | None:
    """Where the reconstruction's files of a form (``txt``, ``bin``) are."""
    for place in _PLACES:
        if all((folder / place / f"{part}.{form}").is_file() for part in ("cameras", "images")):
            return folder / place
    return None


def _cameras(path: Path) -> dict[str, Intrinsics]:
    cameras = {}
    for line in filter(str.strip, read_lines(path)):
        words = line.split()
        values = numbers_of(words[4:], str(path))
        kind = words[1] if len(words) > 1 else ""
        places = _PARAMETERS.get(kind)
        if places is None or len(values) <= max(places) or any(values[max(places) + 1 :]):
            raise SequenceError(
                f"{path}: camera {line!r}; pictures without distortion are needed: colmap "
                "image_undistorter"
            )
        fx, fy, cx, cy = (values[place] for place in places)
        # COLMAP's pixels have their centres at half numbers
        matrix = [[fx, 0, cx - 0.5], [0, fy, cy - 0.5], [0, 0, 1]]
        cameras[words[0]] = checked_intrinsics(matrix, str(path))
    return cameras


def _depth(folder: Path, name: str) -> LazyArray:
    picture = (folder / "depth" / name).with_suffix(".png")
    if picture.is_file():
        return DepthPicture(picture)
    dense = folder / "stereo" / "depth_maps" / f"{name}.geometric.bin"
    if dense.is_file():
        return ColmapDepth(dense)
    raise SequenceError(f"{name} has no depth: neither {picture} nor {dense} is there")
