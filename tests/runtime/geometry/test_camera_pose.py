"""What is known of the camera's pose, and the planes that follow."""

import math

import numpy as np
import pytest
from predictions import make_prediction

from footprints_edge.errors import CameraPoseError, GroundPlaneError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.geometry.camera_pose import CameraPose, up_vector
from footprints_edge.geometry.ground_plane import GroundPlane

SIZE = (96, 128)
CAMERA = Intrinsics(100, 100, 63.5, 20.0)


@pytest.mark.parametrize(("pitch_deg", "roll_deg"), [(0, 0), (20, 0), (-10, 15), (35, -8)])
def test_angles_gravity_and_the_planes_up_agree(pitch_deg, roll_deg):
    plane = GroundPlane(up_vector(pitch_deg, roll_deg), 1.0, 0.0)
    assert plane.pitch_deg == pytest.approx(pitch_deg)
    assert plane.roll_deg == pytest.approx(roll_deg)
    pose = CameraPose.from_gravity(tuple(-9.81 * plane.up), 1.2)
    assert (pose.pitch_deg, pose.roll_deg) == pytest.approx((pitch_deg, roll_deg))
    assert pose.everything


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: CameraPose(0), "camera height is 0"),
        (lambda: CameraPose(math.nan), "camera height is nan"),
        (lambda: CameraPose(pitch_deg=91), "pitch is 91"),
        (lambda: CameraPose(roll_deg=math.nan), "roll is nan"),
        (lambda: CameraPose.from_gravity((0, 0, 0)), "gravity is"),
        (lambda: CameraPose.from_gravity((0, 1)), "gravity is"),
    ],
)
def test_impossible_poses_are_refused(make, says):
    with pytest.raises(CameraPoseError, match=says):
        make()


def seen(pose, error=1.0):
    """A floor 1.5 m below a camera that looks down by 20 degrees and leans by 5; the network's
    depth is wrong by a factor."""
    plane = GroundPlane(up_vector(20, 5), 1.5, 0.0)
    inverse_depth = np.maximum(plane.inverse_depth(CAMERA, SIZE), 1e-2)
    prediction = make_prediction(error / inverse_depth, intrinsics=CAMERA)
    object.__setattr__(prediction, "pose", pose)
    return prediction


@pytest.mark.parametrize(
    "pose",
    [
        CameraPose(),
        CameraPose(1.5),
        CameraPose(pitch_deg=20),
        CameraPose(roll_deg=5),
        CameraPose(None, 20, 5),
        CameraPose(1.5, 20),
        CameraPose(1.5, None, 5),
        CameraPose(1.5, 20, 5),
    ],
)
def test_the_known_part_holds_and_the_rest_is_fitted(pose):
    plane = seen(pose).ground_plane()
    found = (plane.camera_height_m, plane.pitch_deg, plane.roll_deg)
    assert found == pytest.approx((1.5, 20, 5), abs=0.3)
    for known, value in zip((pose.height_m, pose.pitch_deg, pose.roll_deg), found, strict=True):
        assert known is None or value == pytest.approx(known)


def test_a_known_pose_is_exact_whatever_the_network_says():
    prediction = seen(CameraPose(1.5, 20, 5), error=1.7).flattened()
    np.testing.assert_allclose(
        prediction.ground_depth_m[50:], seen(CameraPose()).ground_depth_m[50:], rtol=1e-4
    )
    none = prediction.with_maps(ground_probability=np.zeros(SIZE, np.float32))
    assert none.ground_plane().camera_height_m == 1.5
    assert not none.top_down().free.any()


def test_angles_that_are_known_leave_the_scale_to_the_network():
    plane = seen(CameraPose(None, 20, 5), error=1.2).ground_plane()
    assert plane.camera_height_m == pytest.approx(1.8, rel=0.01)


@pytest.mark.parametrize(
    ("ground", "plane", "says"),
    [
        (slice(94, 96), GroundPlane(up_vector(20, 0), 1.5, 0), "shows no ground"),
        (slice(30, 96), GroundPlane(up_vector(20, 60), 1.5, 0), "cannot be the ground"),
        (slice(30, 96), GroundPlane(up_vector(20, 0), 500, 0), "cannot be the ground"),
    ],
)
def test_one_gate_refuses_planes_for_everything(ground, plane, says):
    inverse_depth = np.maximum(plane.inverse_depth(CAMERA, SIZE), 1e-5)
    probability = np.zeros(SIZE)
    probability[ground, 10:40] = 1
    prediction = make_prediction(1 / inverse_depth, ground=probability, intrinsics=CAMERA)
    for ask in (prediction.ground_plane, prediction.top_down, prediction.scan):
        with pytest.raises(GroundPlaneError, match=says):
            ask()
    assert prediction.flattened() is prediction
    from footprints_edge.outputs.json_summary import summarise

    assert summarise(prediction)["ground_plane"] is None


def test_uneven_ground_has_no_plane():
    prediction = seen(CameraPose())
    steps = np.exp(0.4 * np.sin(np.arange(SIZE[0]) / 4)).astype(np.float32)[:, None]
    uneven = prediction.with_maps(
        unmasked_ground_depth_m=prediction.unmasked_ground_depth_m * steps
    )
    with pytest.raises(GroundPlaneError, match="not flat"):
        uneven.ground_plane()


def test_numbers_of_numpy_become_numbers_and_words_are_refused():
    pose = CameraPose(*np.float32([1.5, 10, 2]))
    assert [type(value) for value in (pose.height_m, pose.pitch_deg, pose.roll_deg)] == [float] * 3
    with pytest.raises(CameraPoseError, match="pitch_deg is 'steep'"):
        CameraPose(pitch_deg="steep")
    with pytest.raises(CameraPoseError, match="gravity"):
        CameraPose.from_gravity("down")
