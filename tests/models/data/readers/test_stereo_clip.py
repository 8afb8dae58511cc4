"""A stereo pair of a textured street: labels and depths in closed form."""

import cv2
import numpy as np
import pytest
from PIL import Image

from footprints_edge.errors import FootprintsError
from footprints_edge_models.data.mixture import load_datasets
from footprints_edge_models.data.readers.stereo_clip import read_stereo_clip
from footprints_edge_models.sample import NO, UNKNOWN, YES

STEREO_SIZE = (180, 500)
FOCAL_PX, BASELINE_M, HEIGHT_M = 350.0, 0.5, 1.6


@pytest.fixture
def stereo_clip(tmp_path):
    """A textured street 1.6 m below two cameras, and a textured wall 12 m ahead."""
    folder = tmp_path / "stereo"
    for name in ("image_l", "image_r"):
        (folder / name).mkdir(parents=True)
    rows, columns = np.mgrid[: STEREO_SIZE[0], : STEREO_SIZE[1]].astype(np.float32)
    fall = np.maximum((rows - 69.5) / FOCAL_PX, 1e-6)
    depth_m = np.minimum(HEIGHT_M / fall, 12.0)
    noise = np.random.default_rng(0).integers(0, 256, (180, 700, 3), dtype=np.uint8)
    right = cv2.GaussianBlur(noise, (0, 0), 1)[:, 100:600]
    # The left picture shows at x what the right one shows at x - disparity.
    disparity = (FOCAL_PX * BASELINE_M / depth_m).astype(np.float32)
    left = cv2.remap(right, columns - disparity, rows, cv2.INTER_LINEAR, None, cv2.BORDER_REFLECT)
    Image.fromarray(left).save(folder / "image_l" / "000000.png")
    Image.fromarray(right).save(folder / "image_r" / "000000.png")
    camera = [FOCAL_PX, 0, 249.5, 0, 0, FOCAL_PX, 69.5, 0, 0, 0, 1, 0]
    shifted = list(camera)
    shifted[3] = -FOCAL_PX * BASELINE_M
    np.savetxt(folder / "calib.txt", [camera, shifted])
    return folder, depth_m


def test_a_stereo_clip(stereo_clip):
    folder, depth_m = stereo_clip
    (sample,) = read_stereo_clip(folder)
    assert sample.intrinsics.fx == pytest.approx(FOCAL_PX)
    inside = np.zeros(STEREO_SIZE, bool)
    inside[10:-5, 150:-10] = True
    measured = inside & (sample.visible_depth_m > 0)
    assert measured.sum() > 0.8 * inside.sum()
    off = np.abs(sample.visible_depth_m[measured] / depth_m[measured] - 1)
    assert np.median(off) < 0.02

    road, wall = inside & (depth_m < 10), inside & (depth_m >= 12)
    assert (sample.visible_ground[road] == YES).mean() > 0.8
    assert (sample.visible_ground[road] == NO).mean() < 0.02
    assert (sample.visible_ground[:100][wall[:100]] == YES).mean() < 0.02
    assert (sample.visible_ground[sample.visible_depth_m == 0] == UNKNOWN).all()

    above = np.arange(STEREO_SIZE[0])[:, None] * np.ones(STEREO_SIZE[1]) < 65
    assert (sample.ground[above] == NO).all()  # above the horizon the street never comes
    assert (sample.ground[80:100][wall[80:100]] == UNKNOWN).mean() > 0.9  # behind the wall
    ground = (sample.ground == YES) & inside
    street_m = HEIGHT_M * FOCAL_PX / (np.arange(STEREO_SIZE[0]) - 69.5)[:, None]
    street_m = np.broadcast_to(street_m, STEREO_SIZE)
    np.testing.assert_allclose(sample.ground_depth_m[ground], street_m[ground], rtol=0.05)


@pytest.mark.parametrize("part", ["image_r/000000.png", "calib.txt"])
def test_a_stereo_clip_that_lacks_a_part_says_which(stereo_clip, part):
    folder, _ = stereo_clip
    (folder / part).unlink()
    folder.rename(folder.with_name("kitti_grey_stereo"))
    with pytest.raises(FootprintsError, match=rf"kitti_grey_stereo.*{part.split('/')[-1]}"):
        load_datasets(folder.parent)


def test_a_stereo_frame_without_road_is_left_out(stereo_clip):
    folder, _ = stereo_clip
    blank = Image.new("RGB", STEREO_SIZE[::-1], (90, 90, 90))
    blank.save(folder / "image_l" / "000001.png")
    blank.save(folder / "image_r" / "000001.png")
    assert [sample.name for sample in read_stereo_clip(folder)] == ["stereo/000000"]
