import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footprints_edge.errors import IntrinsicsError
from footprints_edge.geometry.camera import (
    Intrinsics,
    backproject,
    depth_to_disparity,
    disparity_to_depth,
    rays,
)

SIDES = st.integers(1, 5000)


def test_disparity_is_the_papers():
    s = np.array([0.0, 0.3, 1.0])
    np.testing.assert_allclose(disparity_to_depth(s), 1 / (0.01 + 9.99 * s), rtol=1e-12)
    np.testing.assert_allclose(disparity_to_depth(s)[[0, 2]], [100.0, 0.1], rtol=1e-12)


def test_disparity_keeps_the_dtype():
    assert disparity_to_depth(np.zeros((2, 3), np.float32)).dtype == np.float32


@given(st.floats(0, 1), st.floats(0, 1), st.floats(0.01, 1), st.floats(2, 500))
def test_disparity_and_depth_are_inverse_bounded_and_monotone(s, t, near_m, far_m):
    depth_m = disparity_to_depth(s, near_m, far_m)
    assert near_m * (1 - 1e-9) <= depth_m <= far_m * (1 + 1e-9)
    assert depth_to_disparity(depth_m, near_m, far_m) == pytest.approx(s, abs=1e-9)
    if t > s + 1e-9:
        assert disparity_to_depth(t, near_m, far_m) < depth_m


def test_hfov_goes_from_edge_to_edge():
    camera = Intrinsics.from_hfov(90, (480, 640))
    assert camera.fx == pytest.approx(320)
    assert (camera.cx, camera.cy) == (319.5, 239.5)
    assert camera.hfov_deg((480, 640)) == pytest.approx(90)


def test_35mm_equivalent_on_a_35mm_shaped_picture():
    camera = Intrinsics.from_focal_35mm(36, (2400, 3600))  # 36 mm of focal length on 36 mm of film
    assert camera.fx == pytest.approx(3600)
    assert camera.source == "exif"


@given(SIDES, SIDES)
def test_assumed_camera_sees_60_degrees_along_the_longer_side(height, width):
    camera = Intrinsics.assumed((height, width))
    assert 2 * math.atan(max(height, width) / 2 / camera.fx) == pytest.approx(math.radians(60))
    assert camera.source == "assumed"


SIZES = st.tuples(SIDES, SIDES)


@given(st.floats(1, 5000), st.floats(1, 5000), SIZES, SIZES)
def test_scaling_keeps_the_field_of_view_and_goes_back(fx, fy, size, other):
    camera = Intrinsics(fx, fy, 0.3 * size[1], 0.6 * size[0])
    scaled = camera.scaled(size, other)
    assert scaled.hfov_deg(other) == pytest.approx(camera.hfov_deg(size))
    back = scaled.scaled(other, size)
    expected = (camera.fx, camera.fy, camera.cx, camera.cy)
    assert (back.fx, back.fy, back.cx, back.cy) == pytest.approx(expected, rel=1e-6, abs=1e-6)


def test_the_centre_stays_the_centre_when_scaled():
    camera = Intrinsics.from_hfov(60, (300, 400)).scaled((300, 400), (75, 160))
    assert (camera.cx, camera.cy) == ((160 - 1) / 2, (75 - 1) / 2)


@pytest.mark.parametrize(
    "values",
    [(0, 1, 0, 0), (1, -1, 0, 0), (math.nan, 1, 0, 0), (1, 1, math.inf, 0), (1, 1, 10**400, 0)],
)
def test_impossible_cameras_are_refused(values):
    with pytest.raises(IntrinsicsError, match="pixels"):
        Intrinsics(*values)


@pytest.mark.parametrize("hfov_deg", [0, 180, -3, math.nan])
def test_impossible_fields_of_view_are_refused(hfov_deg):
    with pytest.raises(IntrinsicsError, match="between 0 and 180"):
        Intrinsics.from_hfov(hfov_deg, (2, 2))


def test_backprojected_points_project_onto_their_pixels():
    camera = Intrinsics(50, 60, 3.2, 1.7)
    depth_m = np.random.default_rng(0).uniform(1, 9, (5, 7)).astype(np.float32)
    x, y, z = np.moveaxis(backproject(depth_m, camera), -1, 0)
    rows, columns = np.indices((5, 7))
    np.testing.assert_allclose(camera.fx * x / z + camera.cx, columns, atol=1e-4)
    np.testing.assert_allclose(camera.fy * y / z + camera.cy, rows, atol=1e-4)
    np.testing.assert_array_equal(z, depth_m)


def test_rays_are_float32_with_unit_z():
    directions = rays(Intrinsics(10, 10, 1, 1), (3, 4))
    assert directions.dtype == np.float32
    assert directions.shape == (3, 4, 3)
    np.testing.assert_array_equal(directions[1, 1], [0, 0, 1])
