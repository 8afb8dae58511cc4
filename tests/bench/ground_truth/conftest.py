"""Datasets in their published layouts, small and synthetic."""

import numpy as np
import pytest
from PIL import Image

SIZE = (120, 160)


def save_mask(path, mask):
    Image.fromarray(np.where(mask, np.uint8(255), np.uint8(0))).save(path)


def save_picture(path, size=SIZE):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.full((*size, 3), 90, np.uint8)).save(path)


@pytest.fixture
def kitti(tmp_path):
    """Two annotated images: a polygon of ground and the footprint of a thing within it."""
    folder = tmp_path / "annotations"
    folder.mkdir()
    for number in ("00000", "00001"):
        ground, thing = np.zeros(SIZE, bool), np.zeros(SIZE, bool)
        ground[60:], thing[80:90, 50:70] = True, True
        save_mask(folder / f"{number}_ground.png", ground)
        save_mask(folder / f"{number}_objects.png", thing)
        save_mask(folder / f"{number}_combined.png", ground & ~thing)
    return folder


@pytest.fixture
def matterport(tmp_path):
    """One test image with its raw data: floor at 2 m, a thing hides some of it at 1 m."""
    folder, raw = tmp_path / "truth", tmp_path / "raw" / "scan1" / "scan1"
    folder.mkdir()
    ground_m = np.zeros((64, 80), np.float32)
    ground_m[32:] = 2.0
    region = np.zeros((64, 80), np.float32)
    region[40:] = 1.0
    np.save(folder / "scan1_abc_1_4_groundtruth.npy", ground_m)
    np.save(folder / "scan1_abc_1_4_freespace.npy", region)
    save_picture(raw / "matterport_color_images" / "abc_i1_4.jpg", (128, 160))
    cameras = raw / "matterport_camera_intrinsics"
    cameras.mkdir()
    (cameras / "abc_intrinsics_1.txt").write_text("160 128 150.5 151.5 80.5 62.5 0 0 0 0 0\n")
    return folder, raw
