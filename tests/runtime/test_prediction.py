import copy
import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from predictions import make_prediction

from footprints_edge.errors import MissingMapError
from footprints_edge.geometry.camera import Intrinsics, rays
from footprints_edge.outputs.writers import FORMATS


def prediction_of(depth_m, image_size, probability=None, outputs="all"):
    camera = Intrinsics(40, 50, 23.1, 15.3)
    return make_prediction(
        depth_m, ground=probability, intrinsics=camera, picture=image_size, outputs=outputs
    )


def plane_depth_m(camera, size, normal, height_m):
    """Depth of the plane normal . point = height: analytic, at any size."""
    return (height_m / (rays(camera, size) @ np.asarray(normal, np.float32))).astype(np.float32)


@settings(deadline=None, max_examples=30)
@given(st.floats(-0.2, 0.2), st.floats(0.5, 3), st.integers(1, 5), st.integers(1, 5))
def test_planes_stay_planes_at_image_size(tilt, height_m, times_y, times_x):
    size, large = (32, 48), (32 * times_y, 48 * times_x)
    normal = (tilt, 0.4, 1.0)
    small = prediction_of(
        plane_depth_m(Intrinsics(40, 50, 23.1, 15.3), size, normal, height_m), large
    )
    result = small.at_image_size()
    expected_m = plane_depth_m(result.intrinsics, large, normal, height_m)
    inner = np.s_[times_y:-times_y, times_x:-times_x]  # the outermost half pixel has no neighbour
    np.testing.assert_allclose(result.ground_depth_m[inner], expected_m[inner], rtol=2e-5)
    np.testing.assert_allclose(result.visible_depth_m[inner], expected_m[inner], rtol=2e-5)


def test_at_image_size_everything_has_the_pictures_size():
    result = prediction_of(np.full((32, 48), 3, np.float32), (70, 50)).at_image_size()
    assert result.map_size == result.image_size == (70, 50)
    assert result.ground.shape == result.visible_depth_m.shape == (70, 50)
    assert result.intrinsics == Intrinsics(40, 50, 23.1, 15.3).scaled((32, 48), (70, 50))
    assert result.at_image_size() is result


def test_maps_larger_than_any_picture_are_refused():
    with pytest.raises(ValueError, match="give a smaller size"):
        prediction_of(np.full((4, 4), 3, np.float32), (4, 4)).at_size((10**6, 10**6))


def test_probabilities_are_resized_before_the_threshold():
    probability = np.repeat(np.float32([[0.0, 0.0, 0.8, 0.8]]), 4, 0)
    depth_m = np.full((4, 4), 3, np.float32)
    result = prediction_of(depth_m, (4, 64), probability).at_image_size()
    edge = np.flatnonzero(result.ground[0])[0]
    # 0.5 is reached 0.625 of the way between the centres of pixels 1 and 2, at 24 and 40
    assert edge == 24 + 16 * 0.625
    np.testing.assert_array_equal(np.isnan(result.ground_depth_m), ~result.ground)


@pytest.mark.parametrize("field", ["ground", "visible_ground", "threshold"])
def test_predictions_are_read_only(field):
    prediction = prediction_of(np.ones((2, 2), np.float32), (2, 2))
    with pytest.raises(AttributeError):
        setattr(prediction, field, None)


def test_a_missing_map_is_explained_when_it_is_read():
    depth_m = np.full((32, 48), 3, np.float32)
    masks = prediction_of(depth_m, (64, 96), outputs="masks")
    depths = prediction_of(depth_m, (64, 96), outputs="depths")
    for prediction in (masks, masks.at_image_size()):
        assert prediction.ground.all() and not prediction.hidden_ground.any()
        assert prediction.has("ground_probability") and not prediction.has("visible_depth_m")
        for name in ("visible_depth_m", "unmasked_ground_depth_m", "ground_depth_m"):
            with pytest.raises(MissingMapError, match=r"no depths.*--outputs masks"):
                getattr(prediction, name)
    for prediction in (depths, depths.at_image_size()):
        np.testing.assert_allclose(prediction.visible_depth_m, 3, rtol=1e-6)
        for name in ("ground", "visible_ground", "hidden_ground", "ground_depth_m"):
            with pytest.raises(MissingMapError, match="no masks"):
                getattr(prediction, name)
    assert masks.at_image_size().map_size == depths.at_image_size().map_size == (64, 96)
    with pytest.raises(AttributeError, match="nonsense"):
        masks.nonsense  # noqa: B018


def test_partial_predictions_are_written_as_far_as_they_go(tmp_path):
    depth_m = np.full((32, 48), 3, np.float32)
    masks = prediction_of(depth_m, (32, 48), outputs="masks")
    masks.save(tmp_path, ["npz", "json"], name="a")
    with np.load(tmp_path / "a.npz") as arrays:
        assert arrays["ground"].all()
        assert not [name for name in arrays if name.endswith("depth_m")]
    facts = json.loads((tmp_path / "a.json").read_text())
    assert facts["ground_fraction"]["all"] == 1
    assert facts["ground_distance_m"]["nearest"] is None
    with pytest.raises(MissingMapError):
        masks.save(tmp_path, ["overlay"], name="a")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "a.npz"]


COPIES = {
    "itself": lambda prediction: prediction,
    "replace": lambda prediction: replace(prediction, threshold=0.25),
    "deepcopy": copy.deepcopy,
}
PRESENT = {
    "all": {"masks", "depths"},
    "masks": {"masks"},
    "depths": {"depths"},
}
NEEDS_NO_MAP = {"npz", "json", "png16"}


@pytest.fixture(params=PRESENT)
def outputs(request):
    """Which maps the model file has."""
    return request.param


@pytest.fixture
def floor(outputs):
    """A level floor; its right half is ground with a probability of 0.998, its left half of 0.3."""
    camera = Intrinsics(40, 50, 23.1, 15.3)
    depth_m = np.abs(plane_depth_m(camera, (32, 48), (0, 0.9, 0.9), 1.5))
    probability = np.where(np.arange(48) < 24, 0.3, 0.998) + np.zeros((32, 48))
    return prediction_of(depth_m, (64, 96), probability, outputs)


@pytest.mark.parametrize("copied", COPIES)
def test_every_prediction_has_a_short_repr_and_knows_its_maps(floor, outputs, copied):
    prediction = COPIES[copied](floor)
    text = repr(prediction)
    assert "\n" not in text and len(text) < 250
    assert "maps 32 x 48, image 64 x 96" in text
    for name in ("ground_probability", "visible_ground_probability", "ground", "hidden_ground"):
        assert hasattr(prediction, name) == ("masks" in PRESENT[outputs]), name
    for name in ("visible_depth_m", "unmasked_ground_depth_m"):
        assert hasattr(prediction, name) == ("depths" in PRESENT[outputs]), name
    assert hasattr(prediction, "ground_depth_m") == (outputs == "all")


@pytest.mark.parametrize("outputs", ["all", "masks"])
def test_a_replaced_threshold_applies_to_the_masks(floor):
    assert floor.ground.mean() == 0.5
    assert replace(floor, threshold=0.25).ground.all()
    assert floor.ground.mean() == 0.5
    assert "ground 100%" in repr(replace(floor, threshold=0.25))


@pytest.mark.parametrize("copied", COPIES)
@pytest.mark.parametrize("output_format", FORMATS)
def test_each_format_is_written_or_names_the_missing_map(
    floor, outputs, copied, output_format, tmp_path
):
    prediction = COPIES[copied](floor)
    if outputs != "all" and output_format not in NEEDS_NO_MAP:
        with pytest.raises(MissingMapError, match="--outputs"):
            prediction.save(tmp_path, [output_format], name="a")
        return
    written = prediction.save(tmp_path, [output_format], name="a")
    suffixes = list(FORMATS[output_format])
    if output_format == "png16" and outputs != "all":  # what the file lacks is left out
        suffixes = suffixes[:1] if outputs == "depths" else suffixes[2:]
    assert written == [tmp_path / f"a{suffix}" for suffix in suffixes]
    assert all(path.stat().st_size for path in written)
    if copied == "deepcopy":
        for path in floor.save(tmp_path / "original", [output_format], name="a"):
            assert path.read_bytes() == (tmp_path / path.name).read_bytes()
