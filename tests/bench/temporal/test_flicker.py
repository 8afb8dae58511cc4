"""Flicker, on a synthetic clip whose flicker is known."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from footprints_edge_bench.temporal.flicker import (
    FlickerScores,
    _flicker,
    _floor,
    _surface,
    _View,
    as_markdown,
)

pytest.importorskip("cv2")
SIZE = (120, 160)


@pytest.fixture
def views(camera, pose, floor_of):
    """Two views of the floor z = 0; the second is 0.3 m farther along and turned a little."""
    from footprints_edge_models.mapping.floor_map import DepthFrame

    made = []
    for place in (pose(25.0), pose(27.0, 2.0, 0.1, 0.3)):
        depth_m = floor_of(place)[1]
        measured = DepthFrame(depth_m.astype(np.float32), camera, place)
        made.append(_View(measured, depth_m, SimpleNamespace(size=SIZE)))
    return made


def pairs(views):
    return _surface(*views), _floor(*views)


def test_pairs_are_pixels_of_one_place(views, floor_of, pose):
    first, second = floor_of(pose(25.0))[0], floor_of(pose(27.0, 2.0, 0.1, 0.3))[0]
    for there, here in pairs(views):
        assert len(here) > 5000
        a, b = first.reshape(-1, 3)[there], second.reshape(-1, 3)[here]
        distance_m = np.linalg.norm(a - b, axis=1)
        assert np.median(distance_m) < 0.05
        near = np.linalg.norm(b[:, :2], axis=1) < 3
        assert distance_m[near].max() < 0.1


def test_exact_maps_do_not_flicker_and_changed_ones_do_as_much_as_they_change(views, predicted):
    everywhere = np.ones(SIZE)
    depths = [view.floor_depth_m for view in views]
    before, after = (predicted(everywhere, None, depth, depth) for depth in depths)
    surface, floor = pairs(views)
    np.testing.assert_allclose(_flicker(before, after, *views, surface, floor), 0, atol=1e-3)
    # a tenth of the columns change; depths come out 7 % larger
    changed = everywhere.copy()
    changed[:, ::10] = 0
    other = predicted(changed, changed, 1.07 * depths[1], 1.07 * depths[1])
    found = _flicker(before, other, *views, surface, floor)
    assert found[:2] == pytest.approx([0.1, 0.1], abs=0.02)
    assert found[2:] == pytest.approx([np.log(1.07)] * 2, abs=1e-3)


def test_what_moves_in_the_picture_only_because_the_camera_moves_is_no_flicker(
    views, predicted, pose, floor_of
):
    """Ground left of x = 0, in the world: its border crosses other pixels in each view."""
    masks = [
        (floor_of(place)[0][..., 0] < 0).astype(float)
        for place in (pose(25.0), pose(27.0, 2.0, 0.1, 0.3))
    ]
    assert (masks[0] != masks[1]).mean() > 0.02
    before, after = (
        predicted(mask, None, view.floor_depth_m, view.floor_depth_m)
        for mask, view in zip(masks, views, strict=True)
    )
    found = _flicker(before, after, *views, *pairs(views))
    assert max(found[:2]) < 0.01


def test_the_table_has_a_row_for_each_way():
    figures = FlickerScores(0.02, 0.04, 0.05, 0.06, 0.9, 0.8, 0.7, 0.6)
    table = as_markdown({"office": {"Frame by frame": figures, "Smoothed": replace(figures)}})
    assert (
        "| Smoothed | 2.00 % | 4.00 % | 6.00 % | 5.00 % | 0.900 | 0.800 | 0.600 | 0.700 |" in table
    )
