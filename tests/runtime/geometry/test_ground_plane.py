import numpy as np
import pytest

from footprints_edge.errors import GroundPlaneError
from footprints_edge.geometry.camera import Intrinsics, backproject
from footprints_edge.geometry.camera_pose import CameraPose
from footprints_edge.geometry.ground_plane import (
    _drawn,
    _least_middle,
    _median,
    find_ground_plane,
    fit_ground_plane,
)

SIZE = (96, 128)
CAMERA = Intrinsics(100, 105, 63.0, 40.0)


def floor_depth_m(height_m, pitch_deg, roll_deg=0.0, camera=CAMERA, size=SIZE):
    """Depth of a level floor, by rotating every ray into the world; infinite above the horizon."""
    pitch, roll = np.radians([pitch_deg, roll_deg])
    x = (np.arange(size[1]) - camera.cx)[None, :] / camera.fx
    y = (np.arange(size[0]) - camera.cy)[:, None] / camera.fy
    down = np.cos(pitch) * (np.cos(roll) * y + np.sin(roll) * x) + np.sin(pitch)
    with np.errstate(divide="ignore"):
        return np.where(down > 1e-3, height_m / down, np.inf).astype(np.float32)


@pytest.mark.parametrize("height_m", [0.3, 1.5, 8.0])
@pytest.mark.parametrize(("pitch_deg", "roll_deg"), [(0, 0), (12, 0), (35, -6), (60, 10), (-5, 3)])
def test_a_floor_gives_back_the_camera_above_it(height_m, pitch_deg, roll_deg):
    depth_m = floor_depth_m(height_m, pitch_deg, roll_deg)
    plane = fit_ground_plane(depth_m, np.isfinite(depth_m), CAMERA)
    assert plane.camera_height_m == pytest.approx(height_m, rel=1e-4)
    assert plane.pitch_deg == pytest.approx(pitch_deg, abs=0.01)
    assert plane.roll_deg == pytest.approx(roll_deg, abs=0.01)
    assert plane.error_m < 1e-3 * height_m


def test_a_third_of_wrong_depths_changes_little():
    depth_m = floor_depth_m(1.5, 20)
    ground = np.isfinite(depth_m)
    rng = np.random.default_rng(0)
    noisy = 1 / (1 / depth_m + rng.normal(0, 0.002, SIZE))
    wrong = rng.random(SIZE) < 1 / 3
    noisy[wrong] = rng.uniform(0.5, 3, SIZE)[wrong]
    plane = fit_ground_plane(noisy.astype(np.float32), ground, CAMERA)
    assert plane.camera_height_m == pytest.approx(1.5, abs=0.02)
    assert plane.pitch_deg == pytest.approx(20, abs=0.5)


def test_axes_are_forward_left_up_and_right_handed():
    depth_m = floor_depth_m(1.5, 20, 5)
    axes = fit_ground_plane(depth_m, np.isfinite(depth_m), CAMERA).axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(np.cross(axes[0], axes[1]), axes[2], atol=1e-12)
    assert axes[0, 2] > 0.9 and axes[1, 0] < -0.9 and axes[2, 1] < -0.9


def test_pixels_and_metres_agree_with_the_depth_that_made_the_plane():
    depth_m = floor_depth_m(1.5, 20, 5)
    plane = fit_ground_plane(depth_m, np.isfinite(depth_m), CAMERA)
    rows, columns = np.nonzero(depth_m < 20)
    pixels = np.stack([columns, rows], axis=1)
    places_m = plane.at_pixels(pixels, CAMERA)
    expected = plane.to_ground(backproject(np.minimum(depth_m, 99), CAMERA))[rows, columns]
    np.testing.assert_allclose(expected[:, 2], 0, atol=2e-3)
    np.testing.assert_allclose(places_m, expected[:, :2], atol=5e-3)
    np.testing.assert_allclose(plane.to_pixels(places_m, CAMERA), pixels, atol=1e-8)


def test_above_the_horizon_and_behind_the_camera_there_is_nothing():
    depth_m = floor_depth_m(1.5, 0)
    plane = fit_ground_plane(depth_m, np.isfinite(depth_m), CAMERA)
    assert np.isnan(plane.at_pixels(np.array([[60.0, 10.0]]), CAMERA)).all()
    assert np.isnan(plane.to_pixels(np.array([[-3.0, 0.0]]), CAMERA)).all()


def test_a_camera_that_looks_straight_down_has_forward_up_in_the_picture():
    plane = fit_ground_plane(np.full(SIZE, 2, np.float32), np.ones(SIZE, bool), CAMERA)
    assert (plane.camera_height_m, plane.pitch_deg) == pytest.approx((2, 90), abs=1e-3)
    np.testing.assert_allclose(
        plane.at_pixels(np.array([[63.0, 40.0 - 52.5]]), CAMERA), [[1.0, 0.0]], atol=1e-4
    )


def test_ground_without_a_plane_is_explained():
    depth_m = floor_depth_m(1.5, 20)
    few = np.zeros(SIZE, bool)
    few[-1, :5] = True
    with pytest.raises(GroundPlaneError, match="5 pixels are ground"):
        fit_ground_plane(depth_m, few, CAMERA)
    row = np.zeros(SIZE, bool)
    row[-1] = True
    with pytest.raises(GroundPlaneError, match="one line"):
        fit_ground_plane(depth_m, row, CAMERA)
    with pytest.raises(GroundPlaneError, match="above the camera"):
        fit_ground_plane(depth_m[::-1], np.isfinite(depth_m[::-1]), Intrinsics(100, 105, 63, 55))


def test_what_is_drawn_is_what_the_documentation_says():
    """docs/porting-metres.md: other languages draw the same."""
    assert _drawn(6, 8000).tolist() == [0, 2540, 1529, 4185, 1144, 6376]
    assert set(_drawn(1050, 20)) == set(range(20))


def test_a_refusal_has_a_word_for_programs():
    depth_m = floor_depth_m(1.5, 20)
    ground = np.isfinite(depth_m)

    def reason(depth_m, ground, camera=CAMERA, pose=CameraPose()):  # noqa: B008 - it is frozen
        with pytest.raises(GroundPlaneError) as caught:
            find_ground_plane(depth_m, ground, camera, pose)
        return caught.value.reason

    few, row, little = (np.zeros(SIZE, bool) for _ in range(3))
    few[-1, :5] = row[-1] = little[-6:, :40] = True
    assert reason(depth_m, few) == "few_pixels"
    assert reason(depth_m, row) == "one_line"
    assert reason(depth_m, little & (np.arange(SIZE[1]) % 2 == 0)) == "little_ground"
    assert reason(depth_m, ground, pose=CameraPose(height_m=0.02)) == "impossible_pose"
    turned = depth_m[::-1], ground[::-1], Intrinsics(100, 105, 63, 55)
    assert reason(*turned) == "above_camera"
    rough = np.exp(np.random.default_rng(0).normal(0, 0.4, SIZE))
    assert reason((depth_m * rough).astype(np.float32), ground) == "not_flat"


@pytest.mark.parametrize("count", [20, 599, 600])
def test_the_row_with_the_least_middle_is_the_one_that_sorting_finds(count):
    rng = np.random.default_rng(count)
    for levels in (4, 10**6):  # many ties, and none
        rows = rng.integers(levels, size=(150, count)).astype(np.float32)
        assert _least_middle(rows) == np.sort(rows, 1)[:, count // 2].argmin()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("count", [1, 2, 7, 800])
def test_the_median_is_numpys_to_the_bit(count, dtype):
    values = np.random.default_rng(count).normal(size=count).astype(dtype)
    assert _median(values) == np.median(values)
