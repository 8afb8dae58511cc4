"""Camera poses from KITTI's GPS and inertial records, by the formulas of its development kit."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.sequences.camera_files import checked_pose
from footprints_edge_models.sequences.sequence import SequenceError

_EARTH_RADIUS_M = 6378137.0

Calibration = dict[str, NDArray[np.float64]]
"""Numbers by their key."""


def read_calibration(path: Path) -> Calibration:
    """A KITTI calibration file: a key, a colon and numbers a line; other lines are left out.

    Raises:
        SequenceError: it cannot be read.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError) as error:
        raise SequenceError(f"{path}: no readable calibration ({error})") from error
    numbers = {}
    for line in lines:
        key, _, values = line.partition(":")
        try:
            numbers[key.strip()] = np.array([float(value) for value in values.split()])
        except ValueError:  # the calibration's date, the distance between its corners
            continue
    return numbers


def read_oxts_poses(records: Path, calibrations: Path) -> dict[int, NDArray[np.float64]]:
    """Poses of the left colour camera, ``image_02``.

    Args:
        records: folder ``oxts/data`` of a drive, a text file a frame.
        calibrations: folder of ``calib_imu_to_velo.txt``, ``calib_velo_to_cam.txt`` and
            ``calib_cam_to_cam.txt``.

    Returns:
        Camera to world, float64 (4, 4), by frame number. The world is where the drive's first
        record was taken: x east, y north, z up.

    Raises:
        SequenceError: a file is missing or not laid out as documented.
    """
    imu_to_camera = _imu_to_camera(calibrations)
    camera_to_imu = np.linalg.inv(imu_to_camera)
    poses: dict[int, NDArray[np.float64]] = {}
    scale, origin = 0.0, np.zeros(3)
    for path in sorted(records.glob("*.txt")):
        try:
            values = np.loadtxt(path, max_rows=1)[:6]
        except (OSError, ValueError, IndexError) as error:
            raise SequenceError(f"{path}: no readable GPS record ({error})") from error
        latitude, longitude, altitude, roll, pitch, yaw = values
        if not poses:
            scale = float(np.cos(np.radians(latitude)))
        place = np.array(
            [
                scale * _EARTH_RADIUS_M * np.radians(longitude),
                scale * _EARTH_RADIUS_M * np.log(np.tan(np.radians(90 + latitude) / 2)),
                altitude,
            ]
        )
        if not poses:
            origin = place
        imu_to_world = np.eye(4)
        imu_to_world[:3, :3] = _turn(2, yaw) @ _turn(1, pitch) @ _turn(0, roll)
        imu_to_world[:3, 3] = place - origin
        poses[int(path.stem)] = checked_pose(imu_to_world @ camera_to_imu, str(path))
    return poses


def _imu_to_camera(folder: Path) -> NDArray[np.float64]:
    cameras = read_calibration(folder / "calib_cam_to_cam.txt")
    try:
        rectify = np.eye(4)
        rectify[:3, :3] = cameras["R_rect_00"].reshape(3, 3)
        projection = cameras["P_rect_02"].reshape(3, 4)
        shift = np.eye(4)
        shift[0, 3] = projection[0, 3] / projection[0, 0]
        return shift @ rectify @ _motion(folder, "velo_to_cam") @ _motion(folder, "imu_to_velo")
    except (KeyError, ValueError) as error:
        raise SequenceError(
            f"{folder}: calibration not as documented by KITTI ({error})"
        ) from error


def _motion(folder: Path, name: str) -> NDArray[np.float64]:
    path = folder / f"calib_{name}.txt"
    numbers = read_calibration(path)
    rotation, translation = numbers["R"].reshape(3, 3), numbers["T"].reshape(3, 1)
    return checked_pose(np.hstack([rotation, translation]), str(path))


def _turn(axis: int, angle: float) -> NDArray[np.float64]:
    """Rotation matrix about x (0), y (1) or z (2), angle in radians."""
    cos, sin = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    turn = np.eye(3)
    turn[i, i] = turn[j, j] = cos
    turn[i, j], turn[j, i] = -sin, sin
    return turn
