"""Differences of maps, in closed form."""

import json

import numpy as np
import pytest

from footprints_edge.geometry.camera import depth_to_disparity
from footprints_edge_export.verification.compare import CHANNELS, compare_maps


def maps(visible, ground, visible_m, ground_m):
    """Maps (1, 4, 2, 4) of four arrays that broadcast to (2, 4)."""
    channels = (visible, ground, depth_to_disparity(np.asarray(visible_m, float)))
    channels += (depth_to_disparity(np.asarray(ground_m, float)),)
    return np.stack([np.broadcast_to(c, (2, 4)) for c in channels])[None].astype(np.float32)


def test_the_same_maps_do_not_differ():
    a = maps(np.linspace(0, 1, 8).reshape(2, 4), 0.9, 3, 5)
    found = compare_maps([(a, a), (a, a.copy())])
    assert found.photos == 2
    assert found.max_abs == dict.fromkeys(CHANNELS, 0)
    assert (found.visible_ground_iou, found.ground_iou) == (1, 1)
    assert found.visible_depth_abs_rel == found.ground_depth_abs_rel == 0
    assert found.visible_depth_a1 == found.ground_depth_a1 == 1


def test_largest_difference_of_each_map_over_all_photos():
    a = np.zeros((1, 4, 2, 4), np.float32)
    first, second = a.copy(), a.copy()
    first[0, 0, 1, 2], first[0, 2, 0, 0] = 0.5, 0.125
    second[0, 0, 0, 0], second[0, 3, 1, 1] = 0.25, 1
    found = compare_maps([(a, first), (a, second)])
    assert found.max_abs == {
        "visible_ground": 0.5,
        "ground": 0,
        "visible_depth": 0.125,
        "ground_depth": 1,
    }


def test_iou_is_of_the_pixels_of_all_photos_together():
    left = np.array([0.9, 0.9, 0.1, 0.1])
    top = np.array([[0.9], [0.1]])
    pair = (maps(left, left, 3, 5), maps(top, left, 3, 5))  # 2 of 6 pixels in common
    nothing = maps(0.1, left, 3, 5)
    found = compare_maps([pair, (pair[0], nothing)])  # 2 of 6, and 0 of 4
    assert found.visible_ground_iou == pytest.approx(2 / 10)
    assert found.ground_iou == 1


def test_no_ground_in_either_is_agreement():
    a = maps(0.1, 0.1, 3, 5)
    found = compare_maps([(a, a)])
    assert (found.visible_ground_iou, found.ground_iou) == (1, 1)
    assert np.isnan(found.ground_depth_abs_rel)
    assert np.isnan(found.ground_depth_a1)
    as_json = json.loads(json.dumps(found.as_dict(), allow_nan=False))
    assert as_json["ground_depth_abs_rel"] is None
    assert as_json["visible_depth_abs_rel"] == 0


def test_depths_are_compared_in_metres_and_those_of_the_ground_on_the_ground():
    ground = np.array([0.9, 0.1, 0.1, 0.1])
    a = maps(0.1, ground, 2.0, 4.0)
    b = maps(0.1, ground, 2.0 * np.array([1.1, 1.3, 0.5, 1.0]), [[5.2], [4.4]])
    found = compare_maps([(a, b)])
    assert found.visible_depth_abs_rel == pytest.approx((0.1 + 0.3 + 0.5 + 0) / 4, rel=1e-4)
    assert found.visible_depth_a1 == pytest.approx(2 / 4)  # a half is a factor of two
    assert found.ground_depth_abs_rel == pytest.approx((0.3 + 0.1) / 2, rel=1e-4)
    assert found.ground_depth_a1 == pytest.approx(1 / 2)


def test_each_model_has_its_own_depth_range():
    half = np.full((1, 4, 2, 4), 0.5, np.float32)
    depths_m = [1 / (0.5 / high + 0.5 / low) for low, high in ((0.1, 100), (0.2, 50))]
    found = compare_maps([(half, half)], ((0.1, 100), (0.2, 50)))
    expected = abs(depths_m[1] / depths_m[0] - 1)
    assert found.visible_depth_abs_rel == pytest.approx(expected, rel=1e-5)
