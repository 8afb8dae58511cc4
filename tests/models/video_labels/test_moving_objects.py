import cv2
import numpy as np
import pytest

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.video_labels.moving_objects import (
    checked_flow_px,
    flow_explains_better,
    induced_flow_px,
    is_consistent,
    moving_pixels,
)

CAMERA = Intrinsics(100, 110, 79.5, 59.5)
SIZE = (120, 160)


def sideways(metres):
    move = np.eye(4)
    move[0, 3] = -metres  # the camera steps right: points move left
    return move


def test_a_step_aside_moves_pixels_by_focal_length_over_depth():
    depth_m = np.full(SIZE, 5.0, np.float32)
    depth_m[:60] = 2.0
    flow = induced_flow_px(depth_m, CAMERA, CAMERA, sideways(0.1))
    np.testing.assert_allclose(flow[:60, :, 0], -100 * 0.1 / 2, atol=1e-4)
    np.testing.assert_allclose(flow[60:, :, 0], -100 * 0.1 / 5, atol=1e-4)
    np.testing.assert_allclose(flow[..., 1], 0, atol=1e-4)


def test_a_turn_moves_pixels_whatever_their_depth():
    angle = 0.02
    turn = np.eye(4)
    turn[:3, :3] = cv2.Rodrigues(np.array([0.0, angle, 0.0]))[0]
    near = induced_flow_px(np.full(SIZE, 1.0, np.float32), CAMERA, CAMERA, turn)
    far = induced_flow_px(np.full(SIZE, 9.0, np.float32), CAMERA, CAMERA, turn)
    np.testing.assert_allclose(near, far, atol=1e-3)
    x = (np.arange(160) - CAMERA.cx) / CAMERA.fx
    expected = 100 * np.tan(np.arctan(x) + angle) + CAMERA.cx - np.arange(160)
    np.testing.assert_allclose(near[60, :, 0], expected, atol=1e-3)


def test_unknown_depth_and_points_behind_have_no_flow():
    depth_m = np.full(SIZE, 1.0, np.float32)
    depth_m[:10] = 0
    flow = induced_flow_px(depth_m, CAMERA, CAMERA, np.eye(4))
    assert np.isnan(flow[:10]).all()
    np.testing.assert_allclose(flow[10:], 0, atol=1e-4)
    forward = np.eye(4)
    forward[2, 3] = -2  # through the wall
    assert np.isnan(induced_flow_px(depth_m, CAMERA, CAMERA, forward)).all()


@pytest.fixture(scope="module")
def walk():
    """Two pictures of a textured wall 4 m away from a camera that steps 0.2 m aside; a block of
    40 by 40 pixels moves 12 pixels down besides. Also the camera's motion and the depth."""
    noise = np.random.default_rng(0).uniform(0, 255, (240, 320)).astype(np.float32)
    texture = cv2.normalize(cv2.GaussianBlur(noise, (0, 0), 2.5), None, 0, 255, cv2.NORM_MINMAX)
    texture = np.repeat(texture.astype(np.uint8)[..., None], 3, axis=2)
    shift = round(100 * 0.2 / 4)
    first = texture[60:180, 80:240].copy()
    second = texture[60:180, 80 + shift : 240 + shift].copy()
    block = texture[:40, :40]
    first[40:80, 60:100] = block
    second[52:92, 60 - shift : 100 - shift] = block
    return first, second, sideways(0.2), np.full(SIZE, 4.0, np.float32)


def test_what_moves_against_the_camera_is_found(walk):
    first, second, move, depth_m = walk
    induced = induced_flow_px(depth_m, CAMERA, CAMERA, move)
    returning = induced_flow_px(depth_m, CAMERA, CAMERA, np.linalg.inv(move))
    moving = moving_pixels(induced, checked_flow_px(first, second, induced, returning))
    assert moving[46:74, 66:94].mean() > 0.7
    far_away = np.ones(SIZE, bool)
    far_away[28:104, 48:112] = False
    assert moving[far_away].mean() < 0.01


def test_flow_is_believed_where_it_leads_back():
    forward = np.zeros((*SIZE, 2), np.float32)
    forward[..., 0] = 5
    backward = -forward
    backward[:, 80:, 0] = -3  # arrives from two pixels beside
    believed = is_consistent(forward, backward)
    assert believed[:, :74].all()
    assert not believed[:, 76:].any()


def test_motion_must_explain_the_picture_better_than_standing_still():
    plain = np.full((*SIZE, 3), 120, np.uint8)
    still = np.zeros((*SIZE, 2), np.float32)
    drift = np.full_like(still, 6)
    assert not flow_explains_better(plain, plain, still, drift).any()
    rng = np.random.default_rng(0)
    first = rng.integers(0, 256, (*SIZE, 3), dtype=np.uint8)
    second = np.roll(first, 6, axis=1)  # everything went six pixels to the right
    went = np.zeros_like(still)
    went[..., 0] = 6
    assert flow_explains_better(first, second, still, went)[10:-10, 10:-20].all()
    assert not flow_explains_better(first, second, went, still)[10:-10, 10:-20].any()


@pytest.mark.parametrize(("apart_px", "moves"), [(2.9, False), (3.1, True)])
def test_three_pixels_decide(apart_px, moves):
    induced = np.zeros((*SIZE, 2), np.float32)
    optical = induced.copy()
    optical[50, 50] = 0.6 * apart_px, 0.8 * apart_px
    found = moving_pixels(induced, optical)
    assert found[50, 50] == moves
    assert found.sum() == moves


def test_what_leaves_the_picture_is_not_judged():
    induced = np.zeros((*SIZE, 2), np.float32)
    induced[:, 155:, 0] = 10
    assert not moving_pixels(induced, np.zeros_like(induced)).any()


def test_where_everything_seems_to_move_the_pose_is_wrong():
    induced = np.zeros((*SIZE, 2), np.float32)
    optical = np.full_like(induced, 5)
    assert not moving_pixels(induced, optical).any()
    optical[:, 64:] = 0  # two fifths move
    assert moving_pixels(induced, optical).mean() == pytest.approx(0.4)
