"""Drives of KITTI raw, with or without the training data published with the paper.

Raw: ``{drive}/image_02/data/0000000005.jpg`` (or ``png``) and the same below ``image_03``, the
left and right colour camera; ``{date}/calib_cam_to_cam.txt``; ``{drive}/oxts/data``. A drive is
named like ``2011_09_26/2011_09_26_drive_0001_sync``.

Published, in a folder or a zip that stays packed: ``stereo_matching_disps``, ``ground_seg``,
``poses``, ``optical_flow``, ``hidden_depths``, ``depth_masks`` and ``moving_objects``.
"""

import logging
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.sequences.camera_files import checked_intrinsics, checked_pose
from footprints_edge_models.sequences.gps_poses import read_calibration, read_oxts_poses
from footprints_edge_models.sequences.npy_files import FirstChannel, NpyFile
from footprints_edge_models.sequences.sequence import (
    Flow,
    InTime,
    LazyArray,
    Sequence,
    SequenceError,
    SequenceFrame,
    StereoPair,
)

logger = logging.getLogger(__name__)

LEFT, RIGHT = "image_02", "image_03"

BASELINE_M = 0.54
"""The published baseline of the colour cameras, used where there is no calibration."""
TRAINING_WIDTH_PX = 640


@dataclass(frozen=True)
class Rig:
    """The two rectified colour cameras.

    Attributes:
        intrinsics: of both, in pixels of their images.
        width_px: width of their images.
        baseline_m: distance of the right camera from the left one.
    """

    intrinsics: Intrinsics
    width_px: int
    baseline_m: float

    @property
    def focal_per_width(self) -> float:
        """Horizontal focal length as a share of the width: that of a map of any size."""
        return self.intrinsics.fx / self.width_px


@dataclass(frozen=True)
class Disparity:
    """Published disparity, in pixels of its own width.

    Attributes:
        file: float (h, w).
        focal_per_width: horizontal focal length as a share of the image's width.
        baseline_m: baseline of the cameras.
        bias_px: subtracted from the disparity first, in pixels of a map ``TRAINING_WIDTH_PX`` wide.
    """

    file: NpyFile
    focal_per_width: float
    baseline_m: float
    bias_px: float = 0.0

    def read(self) -> NDArray[np.float32]:
        """Metres along the optical axis, float32 (h, w), 0 where the disparity is not positive."""
        disparity_px = np.squeeze(self.file.read()).astype(np.float32)
        if disparity_px.ndim != 2:
            raise SequenceError(
                f"{self.file.root / self.file.name}: a disparity is (h, w), not "
                f"{disparity_px.shape}"
            )
        width = disparity_px.shape[1]
        disparity_px = disparity_px - self.bias_px * width / TRAINING_WIDTH_PX
        with np.errstate(divide="ignore", invalid="ignore"):
            depth_m = self.focal_per_width * width * self.baseline_m / disparity_px
        return np.where(disparity_px > 0, depth_m, 0).astype(np.float32)


@dataclass(frozen=True)
class FlowFile:
    """Published optical flow: (2, h, w), in pixels of its own size."""

    file: NpyFile

    def read(self) -> NDArray[np.float32]:
        """Movement in x and y, float32 (h, w, 2)."""
        flow = self.file.read()
        if flow.ndim != 3 or flow.shape[0] != 2:
            raise SequenceError(
                f"{self.file.root / self.file.name}: flow is (2, h, w), not {flow.shape}"
            )
        return np.ascontiguousarray(flow.transpose(1, 2, 0), dtype=np.float32)


def is_drive(folder: Path) -> bool:
    """Whether a folder looks like a drive of KITTI raw."""
    return (folder / LEFT / "data").is_dir()


def read_kitti_raw(raw: Path, drive: str, published: Path | None = None) -> Sequence:
    """Read a drive, both cameras, for making labels.

    Poses are the published ones, else those of the GPS records. Depth is the published disparity,
    else the two pictures (then only of the left camera). Frames that lack a pose or depth are left
    out. Intrinsics and baseline are those of the calibration, else the published ones.

    Args:
        raw: folder of KITTI raw.
        drive: such as ``2011_09_26/2011_09_26_drive_0001_sync``.
        published: folder or zip of the published training data, where there is one.

    Raises:
        SequenceError: there is no such drive, or it has neither poses nor GPS records.
    """
    images = {camera: _pictures(raw / drive / camera / "data") for camera in (LEFT, RIGHT)}
    if not images[LEFT]:
        raise SequenceError(f"{raw / drive / LEFT / 'data'}: no pictures of the left camera here")
    rig = rig_of(raw, drive, next(iter(images[LEFT].values())))
    poses, up = _poses(raw, drive, sorted(images[LEFT]), published)
    to_right = np.eye(4)
    to_right[0, 3] = rig.baseline_m
    frames = []
    for time in sorted(poses):
        for camera, side in ((LEFT, np.eye(4)), (RIGHT, to_right)):
            depth = _depth(images, time, camera, rig, drive, published)
            if time not in images[camera] or depth is None:
                continue
            ground = _published(published, f"ground_seg/{drive}/{camera}/data/{time:010d}.npy")
            frames.append(
                SequenceFrame(
                    f"{camera}/{time:010d}",
                    time,
                    images[camera][time],
                    rig.intrinsics,
                    poses[time] @ side,
                    depth,
                    None if ground is None else FirstChannel(ground),
                    _flow(images[camera], poses, time, camera, drive, published),
                )
            )
    left_out = len(images[LEFT]) + len(images[RIGHT]) - len(frames)
    if left_out:
        logger.info("%s: %d pictures without pose or depth are left out", drive, left_out)
    if not frames:
        raise SequenceError(f"{raw / drive}: no picture has a pose and depth")
    name = drive.rsplit("/", 1)[-1]
    return Sequence(name, tuple(frames), InTime(25, 50, 2), least_hits=2, up=up)


def disparity_name(drive: str, camera: str, time: int) -> str:
    """Where the published disparity of a frame is, below the root."""
    return f"stereo_matching_disps/{drive}/{camera}/{time:010d}.npy"


def _published(published: Path | None, name: str) -> NpyFile | None:
    if published is None:
        return None
    file = NpyFile(published, name)
    return file if file.exists() else None


def _pictures(folder: Path) -> dict[int, Path]:
    if not folder.is_dir():
        return {}
    found = sorted(p for p in folder.iterdir() if p.suffix in {".jpg", ".png"} and p.stem.isdigit())
    return {int(path.stem): path for path in found}


def rig_of(raw: Path, drive: str, picture: Path) -> Rig:
    """The cameras of a drive by its calibration, else by the published intrinsics.

    Raises:
        SequenceError: the calibration is not laid out as documented.
    """
    with Image.open(picture) as image:
        width, height = image.size
    path = raw / drive.split("/", 1)[0] / "calib_cam_to_cam.txt"
    if not path.is_file():
        camera = Intrinsics(0.58 * width, 1.92 * height, 0.5 * width, 0.5 * height)
        return Rig(camera, width, BASELINE_M)
    numbers = read_calibration(path)
    try:
        left, right = (numbers[f"P_rect_0{i}"].reshape(3, 4) for i in (2, 3))
    except (KeyError, ValueError) as error:
        raise SequenceError(f"{path}: P_rect_02 or P_rect_03 is not there as 3x4") from error
    camera = checked_intrinsics(left[:, :3], str(path))
    baseline_m = float(left[0, 3] / left[0, 0] - right[0, 3] / right[0, 0])
    return Rig(camera, width, baseline_m)


def _poses(
    raw: Path, drive: str, times: list[int], published: Path | None
) -> tuple[dict[int, NDArray[np.float64]], tuple[float, float, float]]:
    """Poses of the left camera by frame number, and which way is up in their world."""
    poses = {}
    for time in times:
        file = _published(published, f"poses/{drive}/orbslam_poses/{time:010d}.npy")
        if file is not None:
            poses[time] = checked_pose(file.read(), str(file.root / file.name))
    if poses:
        return poses, (0.0, -1.0, 0.0)  # the first camera's axes: y down, for a level car
    records = raw / drive / "oxts" / "data"
    if not records.is_dir():
        raise SequenceError(
            f"{raw / drive}: no poses; they come from the published training data "
            f"(poses/{drive}/orbslam_poses) or from the drive's own oxts/data"
        )
    found = read_oxts_poses(records, raw / drive.split("/", 1)[0])
    return {time: pose for time, pose in found.items() if time in set(times)}, (0.0, 0.0, 1.0)


def _depth(
    images: dict[str, dict[int, Path]],
    time: int,
    camera: str,
    rig: Rig,
    drive: str,
    published: Path | None,
) -> LazyArray | None:
    disparity = _published(published, disparity_name(drive, camera, time))
    if disparity is not None:
        return Disparity(disparity, rig.focal_per_width, rig.baseline_m)
    if camera == LEFT and {time} <= images[LEFT].keys() & images[RIGHT].keys():
        focal_times_baseline = rig.intrinsics.fx * rig.baseline_m
        return StereoPair(images[LEFT][time], images[RIGHT][time], focal_times_baseline)
    return None


def _flow(
    images: dict[int, Path],
    poses: dict[int, NDArray[np.float64]],
    time: int,
    camera: str,
    drive: str,
    published: Path | None,
) -> Flow | None:
    file = _published(published, f"optical_flow/{drive}/{camera}/data/{time:010d}.npy")
    to = time - 1 if time - 1 in images else time + 1
    if file is None or to not in images or to not in poses:
        return None
    return Flow(FlowFile(file), f"{camera}/{to:010d}")
