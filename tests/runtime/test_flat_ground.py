from dataclasses import replace

import numpy as np

from footprints_edge.geometry import Intrinsics, rays
from footprints_edge.images import DecodedImage
from footprints_edge.prediction import ModelInfo, Prediction

SIZE = (96, 128)
CAMERA = Intrinsics(100, 105, 63.0, 20.0)
DOWN = np.array([0.05, np.cos(0.35), np.sin(0.35)])


def plane_m(height_m):
    fall = rays(CAMERA, SIZE) @ (DOWN / np.linalg.norm(DOWN))
    return (height_m / np.maximum(fall, 1e-3)).astype(np.float32)


def floor(depth_m, ground=None):
    probability = np.ones(SIZE, np.float32) if ground is None else ground.astype(np.float32)
    return Prediction(
        visible_ground_probability=probability,
        ground_probability=probability,
        visible_depth_m=depth_m,
        unmasked_ground_depth_m=depth_m,
        picture=DecodedImage(np.zeros((*SIZE, 3), np.uint8)),
        intrinsics=CAMERA,
        threshold=0.5,
        model=ModelInfo("made up", "fp32", "0" * 64, "none"),
        timings_ms={},
    )


def test_noise_on_a_floor_goes_and_everything_else_stays():
    rng = np.random.default_rng(0)
    exact = plane_m(1.5)
    noisy = (exact * np.exp(rng.normal(0, 0.05, SIZE))).astype(np.float32)
    prediction = floor(noisy)
    flat = prediction.flattened()
    np.testing.assert_allclose(flat.unmasked_ground_depth_m, exact, rtol=0.01)
    np.testing.assert_array_equal(flat.visible_depth_m, noisy)
    np.testing.assert_array_equal(flat.ground_probability, prediction.ground_probability)


def test_another_level_keeps_its_depth():
    """A platform that takes a quarter of the picture, much nearer than the floor."""
    depth_m = plane_m(1.5)
    depth_m[:48, :64] = plane_m(0.6)[:48, :64]
    flat = floor(depth_m).flattened()
    np.testing.assert_allclose(flat.unmasked_ground_depth_m, depth_m, rtol=1e-3)


def test_ground_that_is_no_plane_stays_as_it_is():
    bumpy = (plane_m(1.5) * np.exp(np.random.default_rng(1).normal(0, 0.4, SIZE))).astype(
        np.float32
    )
    prediction = floor(bumpy)
    assert prediction.flattened() is prediction


def test_without_a_plane_it_is_the_prediction_itself():
    prediction = floor(plane_m(1.5), np.zeros(SIZE, bool))
    assert prediction.flattened() is prediction


def test_nothing_above_the_horizon_is_touched():
    camera = replace(CAMERA, cy=70.0)
    depth_m = np.full(SIZE, 50, np.float32)
    fall = rays(camera, SIZE)[..., 1]
    depth_m[fall > 0.05] = (1.5 / fall[fall > 0.05]).astype(np.float32)
    prediction = replace(floor(depth_m, fall > 0.05), intrinsics=camera)
    flat = prediction.flattened()
    above = fall <= 0
    np.testing.assert_array_equal(flat.unmasked_ground_depth_m[above], depth_m[above])
    assert np.isfinite(flat.unmasked_ground_depth_m).all()
