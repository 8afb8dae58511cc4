"""What a prediction says about itself: that there is no ground, and how good its metres are."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from predictions import make_prediction

from footprints_edge.drawing.occupancy_grid import draw_bev
from footprints_edge.drawing.overlay import draw_overlay
from footprints_edge.errors import GroundPlaneError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.geometry.camera_pose import CameraPose
from footprints_edge.maps.confidence import CURVES_FILE, GROUND_INPUTS, METRES_INPUTS, curves
from footprints_edge.outputs.json_summary import summarise
from footprints_edge.outputs.writers import FORMATS

SIZE = (96, 128)
CAMERA = Intrinsics(100, 100, 63.5, 47.5)


def floor(probability=0.998, noise=0.0, scale=1.0):
    """A floor 1.5 m below a camera that looks down by 45 degrees: all of the picture."""
    down = ((np.arange(SIZE[0]) - CAMERA.cy) / CAMERA.fy + 1) / math.sqrt(2)
    depth_m = np.repeat((1.5 / down)[:, None], SIZE[1], axis=1)
    rng = np.random.default_rng(0)
    return make_prediction(
        depth_m * np.exp(noise * rng.normal(size=SIZE)),
        ground=np.full(SIZE, probability),
        visible_depth_m=scale * depth_m,
        intrinsics=CAMERA,
        picture=np.full((*SIZE, 3), 90, np.uint8),
        name="wall.jpg",
    )


def test_a_picture_without_ground_has_no_plane_and_no_map_and_says_so():
    wall = floor(probability=0.6)
    assert wall.ground.all()  # the masks stay the network's
    assert not wall.shows_ground
    with pytest.raises(GroundPlaneError, match="shows no ground, with a confidence of"):
        wall.ground_plane()
    with pytest.raises(GroundPlaneError):
        wall.top_down()
    assert "wall.jpg: no ground found" in wall.notes[0]
    assert wall.flattened() is wall
    facts = json.loads(FORMATS["json"][".json"](wall))
    assert facts["ground_plane"] is None and facts["confidence"]["metres"] is None
    assert facts["confidence"]["ground"] == round(wall.confidence.ground, 3)
    assert wall.confidence.ground < 0.5
    assert facts["notes"] == list(wall.notes)


def test_nothing_is_drawn_where_there_is_no_ground():
    def changed(prediction):
        photo = np.asarray(draw_overlay(prediction))[:360, :480]  # enlarged to 480 across
        return (photo != 90).any(axis=-1).mean()

    assert changed(floor(probability=0.6)) == 0
    assert changed(floor()) > 0.9


def test_the_birds_eye_view_says_why_it_is_empty():
    empty, full = (np.asarray(draw_bev(floor(p), 240)).astype(int) for p in (0.6, 0.998))
    upper = slice(40, 80)
    assert (empty[upper, 20:220].min(axis=-1) > 200).sum() > 100  # letters
    assert (empty[120:200] == full[120:200]).mean() < 0.9


def test_real_ground_is_drawn_and_measured():
    assert floor().shows_ground and not floor().notes
    assert floor().ground_plane().camera_height_m == pytest.approx(1.5, rel=0.02)


def test_what_is_known_of_the_pose_is_a_plane_whatever_the_picture_shows():
    wall = replace(floor(probability=0.6), pose=CameraPose(1.2, 20, 0))
    assert wall.ground_plane().camera_height_m == 1.2
    assert wall.confidence.metres == 1.0
    assert not wall.shows_ground


def test_metres_are_believed_less_the_worse_the_plane_fits_and_the_depths_agree():
    exact, noisy, torn = (
        each.confidence.metres for each in (floor(), floor(noise=0.1), floor(scale=1.4))
    )
    assert 1 >= exact > noisy > 0
    assert exact >= torn > 0
    assert math.isnan(floor(probability=0.6).confidence.metres)


def test_laying_the_ground_onto_its_plane_makes_it_no_more_certain():
    rough = floor(noise=0.05)
    assert rough.flattened().laid_onto is not None
    assert rough.flattened().confidence == rough.confidence


def test_ground_up_to_the_top_of_the_picture_must_be_surer():
    """A wall that fills the picture looks like paving from above; a floor ends below a wall."""
    unsure = floor(0.95).maps.ground_probability
    ends = np.where(np.arange(SIZE[0])[:, None] < SIZE[0] // 4, np.float32(0.02), unsure)
    assert not floor(0.95).shows_ground
    assert floor(0.95).with_maps(ground_probability=ends).shows_ground
    assert floor(0.998).shows_ground


def test_the_curves_rise_with_every_input():
    found = curves()
    assert set(found.ground.weights) == set(GROUND_INPUTS)
    assert set(found.metres.weights) == set(METRES_INPUTS)
    assert all(w >= 0 for each in (found.ground, found.metres) for w in each.weights.values())
    assert 0 < found.least_ground <= 0.5
    assert CURVES_FILE.read_text(encoding="utf-8") == found.to_json()


def test_whether_there_is_ground_follows_from_the_confidence():
    rng = np.random.default_rng(0)
    told = set()
    for middle in np.linspace(0.4, 1, 60):
        maps = rng.normal(middle, 0.1, (40, 50)).clip(0, 1)
        prediction = make_prediction(np.ones((40, 50)), ground=maps)
        sure = prediction.confidence.ground >= curves().least_ground
        assert prediction.shows_ground == sure
        told.add(sure)
    assert told == {True, False}


def test_models_without_depths_have_masks_and_no_confidence_in_metres():
    masks = make_prediction(np.ones(SIZE), outputs="masks")
    assert masks.shows_ground
    assert summarise(masks)["confidence"] == {"ground": None, "metres": None}
