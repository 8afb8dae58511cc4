"""Stereo depth of shifted textures, and the road plane of made-up streets."""

import cv2
import numpy as np
import pytest

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.mapping.floor_map import DepthFrame
from footprints_edge_models.mapping.stereo import fit_road, stereo_depth_m

SIZE = (180, 600)
CAMERA = Intrinsics(350.0, 350.0, 299.5, 89.5)
IDENTITY = np.eye(4)


def texture(height, width, seed=0):
    noise = np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)
    return cv2.GaussianBlur(noise, (0, 0), 1)


@pytest.mark.parametrize("disparity_px", [4, 17, 60])
def test_a_shifted_texture_is_where_its_disparity_says(disparity_px):
    wide = texture(120, 500 + disparity_px)
    left, right = wide[:, :500], wide[:, disparity_px:]
    # What is at x in the left picture is at x - d in the right one.
    depth_m = stereo_depth_m(np.ascontiguousarray(left), np.ascontiguousarray(right), 380.0)
    assert depth_m.shape == (120, 500)
    assert depth_m.dtype == np.float32
    middle = depth_m[10:-10, 150:-20]
    assert (middle > 0).mean() > 0.95
    np.testing.assert_allclose(np.median(middle[middle > 0]), 380 / disparity_px, rtol=0.02)
    off = np.abs(middle[middle > 0] * disparity_px / 380 - 1)
    assert (off < 0.1).mean() > 0.98


def test_two_unlike_pictures_match_nowhere_to_speak_of():
    depth_m = stereo_depth_m(texture(120, 500, 1), texture(120, 500, 2), 380.0)
    assert (depth_m > 0).mean() < 0.1
    assert (depth_m >= 0).all()
    assert np.isfinite(depth_m).all()


def street(normal, height_m, camera=CAMERA, size=SIZE):
    """Depth of a plane so far below the camera; 0 at and above the horizon."""
    rows, columns = np.mgrid[: size[0], : size[1]].astype(float)
    rays = np.stack(
        [(columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy, np.ones(size)], -1
    )
    fall = rays @ normal
    with np.errstate(divide="ignore"):
        return np.where(fall < -1e-3, -height_m / fall, 0).astype(np.float32)


def tilted(pitch_deg, roll_deg):
    pitch, roll = np.radians([pitch_deg, roll_deg])
    normal = np.array([np.sin(roll), -np.cos(roll) * np.cos(pitch), np.sin(pitch)])
    return normal / np.linalg.norm(normal)


@pytest.mark.parametrize(("pitch_deg", "roll_deg"), [(0, 0), (4, -3), (-3, 5)])
@pytest.mark.parametrize("noise_m", [0.0, 0.02])
def test_the_road_is_found_below_cars_and_noise(pitch_deg, roll_deg, noise_m):
    rng = np.random.default_rng(0)
    normal = tilted(pitch_deg, roll_deg)
    depth_m = street(normal, 1.65)
    depth_m += (depth_m > 0) * rng.normal(0, noise_m, SIZE).astype(np.float32)
    depth_m[80:140, 200:330] = 9  # a car's back
    plane = fit_road(DepthFrame(depth_m, CAMERA, IDENTITY))
    assert plane is not None
    assert np.degrees(np.arccos(min(1, plane.normal @ normal))) < 0.5
    assert plane.offset_m == pytest.approx(-1.65, abs=0.03)


def test_the_same_frame_gives_the_same_plane():
    depth_m = street(tilted(1, 1), 1.65) + np.random.default_rng(0).normal(0, 0.03, SIZE)
    frame = DepthFrame(depth_m.astype(np.float32), CAMERA, IDENTITY)
    first, second = fit_road(frame), fit_road(frame)
    np.testing.assert_array_equal(first.normal, second.normal)
    assert first.offset_m == second.offset_m


def test_no_road_in_noise():
    depth_m = np.random.default_rng(0).uniform(1, 25, SIZE).astype(np.float32)
    camera = Intrinsics(60.0, 60.0, 299.5, 89.5)  # wide, so that noise fills a large volume
    assert fit_road(DepthFrame(depth_m, camera, IDENTITY)) is None


def test_no_road_on_a_wall():
    assert fit_road(DepthFrame(np.full(SIZE, 4, np.float32), CAMERA, IDENTITY)) is None


def test_no_road_on_a_steep_ramp():
    assert fit_road(DepthFrame(street(tilted(25, 0), 1.65), CAMERA, IDENTITY)) is None


def test_no_road_without_depth():
    assert fit_road(DepthFrame(np.zeros(SIZE, np.float32), CAMERA, IDENTITY)) is None


def test_a_ceiling_is_no_road():
    """Only planes below the camera count: this picture looks up, at a level plane above it."""
    camera = Intrinsics(350.0, 350.0, 299.5, 400.0)
    rows = np.arange(SIZE[0])[:, None] * np.ones(SIZE[1])
    depth_m = (2.0 * camera.fy / (camera.cy - rows)).astype(np.float32)
    assert fit_road(DepthFrame(depth_m, camera, IDENTITY)) is None
