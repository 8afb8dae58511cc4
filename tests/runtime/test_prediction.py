import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footprints_edge.geometry import Intrinsics, rays
from footprints_edge.prediction import ModelInfo, Prediction


def prediction_of(depth_m, image_size, probability=None):
    probability = np.ones_like(depth_m) if probability is None else probability
    return Prediction(
        visible_ground_probability=probability,
        ground_probability=probability,
        visible_depth_m=depth_m,
        unmasked_ground_depth_m=depth_m,
        rgb=np.zeros((*image_size, 3), np.uint8),
        intrinsics=Intrinsics(40, 50, 23.1, 15.3),
        threshold=0.5,
        model=ModelInfo("made up", "fp32", "0" * 64, "none"),
        timings_ms={},
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
