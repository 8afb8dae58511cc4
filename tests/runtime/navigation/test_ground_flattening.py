import copy
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from predictions import make_prediction

import footprints_edge as fp
from footprints_edge.errors import GroundPlaneError
from footprints_edge.geometry.camera import Intrinsics, rays
from footprints_edge.geometry.camera_pose import CameraPose
from footprints_edge.geometry.ground_plane import find_ground_plane
from footprints_edge.outputs.json_summary import summarise
from footprints_edge.prediction import FlattenedWhenRead

SIZE = (96, 128)
CAMERA = Intrinsics(100, 105, 63.0, 20.0)
DOWN = np.array([0.05, np.cos(0.35), np.sin(0.35)])


def plane_m(height_m):
    fall = rays(CAMERA, SIZE) @ (DOWN / np.linalg.norm(DOWN))
    return (height_m / np.maximum(fall, 1e-3)).astype(np.float32)


def floor(depth_m, ground=None):
    return make_prediction(depth_m, ground=ground, intrinsics=CAMERA)


def test_noise_on_a_floor_is_removed_and_everything_else_kept():
    rng = np.random.default_rng(0)
    exact = plane_m(1.5)
    noisy = (exact * np.exp(rng.normal(0, 0.05, SIZE))).astype(np.float32)
    prediction = floor(noisy)
    flat = prediction.flattened()
    # the fit of 40 such floors is off by 0.8 % on average where it is worst, at the far end
    np.testing.assert_allclose(flat.unmasked_ground_depth_m, exact, rtol=0.02)
    np.testing.assert_array_equal(flat.visible_depth_m, noisy)
    np.testing.assert_array_equal(flat.ground_probability, prediction.ground_probability)


def test_the_plane_and_its_error_are_those_of_the_network_depth():
    noise = np.random.default_rng(0).normal(0, 0.05, SIZE)
    prediction = floor((plane_m(1.5) * np.exp(noise)).astype(np.float32))
    flat = prediction.flattened().at_size((48, 64))
    assert flat.ground_plane().error_m == prediction.ground_plane().error_m > 0.01
    inverse_depth = np.reciprocal(flat.unmasked_ground_depth_m[1:-1])  # a resize bends the border
    np.testing.assert_allclose(np.diff(inverse_depth, 2, axis=0), 0, atol=2e-5)  # still a plane


def test_another_level_keeps_its_depth():
    """A platform that takes a quarter of the picture, much nearer than the floor."""
    depth_m = plane_m(1.5)
    depth_m[:48, :64] = plane_m(0.6)[:48, :64]
    flat = floor(depth_m).flattened()
    np.testing.assert_allclose(flat.unmasked_ground_depth_m, depth_m, rtol=1e-3)


def test_uneven_ground_keeps_its_depth():
    bumpy = (plane_m(1.5) * np.exp(np.random.default_rng(1).normal(0, 0.4, SIZE))).astype(
        np.float32
    )
    prediction = floor(bumpy)
    assert prediction.flattened() is prediction


def test_without_a_plane_it_is_the_prediction_itself():
    prediction = floor(plane_m(1.5), np.zeros(SIZE, bool))
    assert prediction.flattened() is prediction


def test_depth_above_the_horizon_is_kept():
    camera = replace(CAMERA, cy=70.0)
    depth_m = np.full(SIZE, 50, np.float32)
    fall = rays(camera, SIZE)[..., 1]
    depth_m[fall > 0.05] = (1.5 / fall[fall > 0.05]).astype(np.float32)
    prediction = replace(floor(depth_m, fall > 0.05), intrinsics=camera)
    flat = prediction.flattened()
    above = fall <= 0
    np.testing.assert_array_equal(flat.unmasked_ground_depth_m[above], depth_m[above])
    assert np.isfinite(flat.unmasked_ground_depth_m).all()


@pytest.mark.parametrize("pose", [CameraPose(), CameraPose(height_m=1.6)])
def test_every_pixel_follows_the_documented_rule_with_a_leaning_horizon_too(pose):
    """docs/porting-metres.md, at all pixels in 64 bits."""
    lean = np.radians(20)
    camera = replace(CAMERA, cy=60.0)
    down = np.array([np.sin(lean), np.cos(lean), 0.05])
    fall = rays(camera, SIZE) @ (down / np.linalg.norm(down))
    rng = np.random.default_rng(0)
    depth_m = (1.5 / np.maximum(fall, 0.03) * np.exp(rng.normal(0, 0.2, SIZE))).astype(np.float32)
    prediction = replace(floor(depth_m, fall > 0.1), intrinsics=camera, pose=pose)
    flat = prediction.flattened()
    p = -rays(camera, SIZE) @ flat.laid_onto.up / flat.laid_onto.camera_height_m
    i = 1 / depth_m.astype(np.float64)
    deviation = np.log(np.where(p > 1e-4, p, 1) / i)
    if pose.anything:
        deviation -= np.median(deviation[prediction.ground])
    weight = np.where(p > 1e-4, ((0.8 - abs(deviation)) / 0.4).clip(0, 1), 0)
    assert {0.0, 1.0} < set(weight.ravel())
    np.testing.assert_allclose(flat.unmasked_ground_depth_m, 1 / (i + weight * (p - i)), rtol=1e-4)


def test_predict_flattens_the_ground_unless_switched_off():
    room = Path(__file__).parents[3] / "examples" / "room.jpg"
    model = fp.load(threads=1)
    flat, plain = model.predict(room), model.predict(room, flatten=False)
    np.testing.assert_array_equal(flat.ground, plain.ground)
    np.testing.assert_array_equal(flat.visible_depth_m, plain.visible_depth_m)
    expected = plain.flattened().ground_depth_m
    np.testing.assert_array_equal(flat.ground_depth_m, expected)
    ratio = (flat.ground_depth_m / plain.ground_depth_m)[flat.ground]
    assert 0.01 < np.abs(np.log(ratio)).mean() < 0.2
    assert plain.laid_onto is None
    assert flat.ground_plane() is flat.laid_onto
    assert flat.flattened() is flat
    plane = summarise(flat)["ground_plane"]
    assert plane["camera_height_m"] == pytest.approx(1.5, abs=0.25)  # as the picture was made
    assert plane["pitch_deg"] == pytest.approx(12, abs=5)
    assert summarise(plain)["ground_plane"]["pitch_deg"] == pytest.approx(plane["pitch_deg"])


def test_masks_and_visible_depth_do_not_wait_for_the_plane(monkeypatch):
    plain = floor(plane_m(1.5) * np.float32(1.1), np.ones(SIZE, bool))
    fits = []
    monkeypatch.setattr(
        "footprints_edge.maps.ground_maps.find_ground_plane",
        lambda *given: fits.append(1) or find_ground_plane(*given),
    )
    later = FlattenedWhenRead.of(plain)
    _ = later.visible_ground, later.hidden_ground, later.visible_depth_m, later.map_size
    _ = later.has("unmasked_ground_depth_m"), repr(later)
    assert fits == []
    np.testing.assert_array_equal(later.ground_depth_m, plain.flattened().ground_depth_m)
    later.ground_plane()
    assert fits == [1]


@pytest.mark.parametrize(
    "copied",
    [
        lambda later: replace(later, threshold=0.4),
        lambda later: later.with_maps(visible_depth_m=later.visible_depth_m),
        lambda later: pickle.loads(pickle.dumps(later)),
        copy.copy,
        lambda later: later.flattened(),
    ],
)
def test_a_copy_of_an_unread_prediction_is_flattened_too(copied):
    plain = floor(plane_m(1.5) * np.float32(1.1), np.ones(SIZE, bool))
    flat, found = plain.flattened(), copied(FlattenedWhenRead.of(plain))
    np.testing.assert_array_equal(found.unmasked_ground_depth_m, flat.unmasked_ground_depth_m)
    np.testing.assert_array_equal(found.visible_depth_m, flat.visible_depth_m)
    assert found.ground_plane() is found.laid_onto
    assert found.flattened() is found
    assert repr(found) == repr(flat)


def test_an_unread_prediction_without_ground_is_the_plain_one():
    plain = floor(plane_m(1.5), np.zeros(SIZE, bool))
    later = FlattenedWhenRead.of(plain)
    assert later.laid_onto is None
    np.testing.assert_array_equal(later.unmasked_ground_depth_m, plain.unmasked_ground_depth_m)
    with pytest.raises(GroundPlaneError):
        later.ground_plane()
