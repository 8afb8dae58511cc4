"""Smoothing on a synthetic clip: a camera that moves over a textured floor, in closed form."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from predictions import make_prediction

from footprints_edge import Tracker
from footprints_edge.errors import VideoError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import DecodedImage
from footprints_edge.maps import ground_maps
from footprints_edge.maps.confidence import METRES_INPUTS, Curve, curves

pytest.importorskip("cv2")

SIZE = (128, 192)
CAMERA = Intrinsics(150, 150, 95.5, 40.0)
HEIGHT_M, PITCH = 1.5, np.radians(25)
STEP_M = 0.04
"""How far the camera goes ahead from frame to frame."""

BORDER_M = (-0.6, 0.8)
"""Ground lies between these y, metres, left positive."""


def texture(x, y):
    """Grey levels of the floor: waves of several lengths, so that flow finds its way."""
    waves = sum(
        np.sin(k * (np.cos(a) * x + np.sin(a) * y) + p)
        for k, a, p in ((5, 0.3, 0), (9, 1.4, 1), (13, 2.3, 2), (21, 0.9, 3), (30, 2.9, 4))
    )
    return np.clip(128 + 22 * waves, 0, 255)


def exact(step):
    """What a perfect network would say of a frame."""
    across = (np.arange(SIZE[1]) - CAMERA.cx)[None, :] / CAMERA.fx + np.zeros(SIZE)
    along = (np.arange(SIZE[0]) - CAMERA.cy)[:, None] / CAMERA.fy + np.zeros(SIZE)
    depth_m = HEIGHT_M / (np.cos(PITCH) * along + np.sin(PITCH))
    assert (depth_m > 0).all()
    x = depth_m * (np.cos(PITCH) - np.sin(PITCH) * along) + step * STEP_M
    y = -depth_m * across
    grey = texture(x, y).astype(np.uint8)
    ground = ((y > BORDER_M[0]) & (y < BORDER_M[1])).astype(np.float32)
    depth_m = depth_m.astype(np.float32)
    picture = np.repeat(grey[..., None], 3, axis=2)
    return make_prediction(depth_m, ground=ground, intrinsics=CAMERA, picture=picture)


def noisy(prediction, rng):
    """The same with errors that change from frame to frame."""

    def disturbed(probability):
        return np.clip(probability + rng.normal(0, 0.3, SIZE), 0, 1).astype(np.float32)

    factor = np.exp(rng.normal(0, 0.1, SIZE)).astype(np.float32)
    return prediction.with_maps(
        visible_ground_probability=disturbed(prediction.visible_ground_probability),
        ground_probability=disturbed(prediction.ground_probability),
        visible_depth_m=prediction.visible_depth_m * factor,
        unmasked_ground_depth_m=prediction.unmasked_ground_depth_m * factor,
    )


MIDDLE = (slice(20, -20), slice(20, -20))


def depth_error(prediction, name):
    expected = exact(0).unmasked_ground_depth_m
    return np.abs(np.log(getattr(prediction, name) / expected))[MIDDLE]


def test_the_first_frame_is_as_the_network_says():
    first = noisy(exact(0), np.random.default_rng(0))
    assert Tracker().update(first) is first


def test_exact_maps_stay_exact_while_the_camera_moves():
    """Forgetting how depths change with the way gone would lag behind by 3 steps, over 4 %."""
    tracker = Tracker()
    for step in range(12):
        smoothed = tracker.update(exact(step))
    assert depth_error(smoothed, "unmasked_ground_depth_m").mean() < 0.01
    moved = smoothed.ground[MIDDLE] != exact(11).ground[MIDDLE]
    assert moved.mean() < 0.005


@pytest.mark.parametrize("name", ["visible_ground", "ground"])
def test_masks_flicker_less_and_are_right_more_often(name):
    rng = np.random.default_rng(1)
    tracker = Tracker()
    wrong = {"raw": [], "smoothed": []}
    for step in range(10):
        expected = exact(step)
        raw = noisy(expected, rng)
        smoothed = tracker.update(raw)
        for key, prediction in (("raw", raw), ("smoothed", smoothed)):
            wrong[key].append((getattr(prediction, name) != expected.ground)[MIDDLE].mean())
    assert np.mean(wrong["smoothed"][4:]) < 0.5 * np.mean(wrong["raw"][4:])


@pytest.mark.parametrize("name", ["visible_depth_m", "unmasked_ground_depth_m"])
def test_depths_get_less_noisy(name):
    rng = np.random.default_rng(2)
    tracker = Tracker()
    for step in range(10):
        raw = noisy(exact(step), rng)
        smoothed = tracker.update(raw)
    # the visible depth's lag of a moving camera is part of the price
    assert depth_error(smoothed, name).mean() < 0.8 * depth_error(raw, name).mean()


def test_the_ground_plane_is_that_of_the_smoothed_depth():
    """Each frame is laid onto a plane of its own, all of them a little too high or too low."""
    rng = np.random.default_rng(3)
    tracker = Tracker()
    heights_m = {"raw": [], "smoothed": []}
    for step in range(16):
        expected = exact(step)
        factor = np.float32(np.exp(rng.normal(0, 0.1)))
        raw = expected.with_maps(
            unmasked_ground_depth_m=expected.unmasked_ground_depth_m * factor
        ).flattened()
        assert raw.laid_onto is not None
        smoothed = tracker.update(raw)
        heights_m["raw"].append(raw.ground_plane().camera_height_m)
        heights_m["smoothed"].append(smoothed.ground_plane().camera_height_m)
    assert np.std(heights_m["smoothed"][4:]) < 0.6 * np.std(heights_m["raw"][4:])


def test_smoothing_makes_metres_no_more_certain(monkeypatch):
    """The depth that it blends was laid onto planes, and so lies on one."""
    inputs = dict.fromkeys(METRES_INPUTS, 0.0) | {"flatness": 1.2}
    by_flatness = replace(curves(), metres=Curve(-2.0, inputs))
    monkeypatch.setattr(ground_maps, "curves", lambda: by_flatness)
    rng = np.random.default_rng(4)
    tracker = Tracker()
    for step in range(4):
        expected = exact(step)
        noise = np.exp(rng.normal(0, 0.1, SIZE)).astype(np.float32)
        rough = expected.with_maps(
            unmasked_ground_depth_m=expected.unmasked_ground_depth_m * noise
        ).flattened()
        smoothed = tracker.update(rough)
        assert smoothed.confidence.metres <= rough.confidence.metres + 0.03
    assert rough.confidence.metres < exact(3).confidence.metres - 0.1


def test_a_cut_resets_the_smoothing():
    tracker = Tracker()
    for step in range(4):
        tracker.update(exact(step))
    dark = DecodedImage(np.full((*SIZE, 3), 5, np.uint8))
    none = np.zeros(SIZE, np.float32)
    other = replace(exact(4), picture=dark).with_maps(
        visible_ground_probability=none, ground_probability=none
    )
    smoothed = tracker.update(other)
    assert not smoothed.visible_ground.any()
    assert not smoothed.ground.any()


def test_a_change_of_size_starts_over():
    tracker = Tracker()
    tracker.update(exact(0))
    small = exact(1).at_size((64, 96))
    assert tracker.update(small) is small


def test_a_missing_opencv_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(VideoError, match=r"footprints-edge\[video\]"):
        Tracker()
