from dataclasses import replace

import numpy as np
import pytest

from footprints_edge.drawing.colormap import colours_of
from footprints_edge.drawing.overlay import LONGEST_PX, NARROWEST_PX, draw_overlay
from footprints_edge.drawing.style import TINT


@pytest.mark.parametrize(
    "size", [(64, 64), (1, 1), (30, 400), (400, 30), (360, 540), (2400, 1600), (1000, 4000)]
)
def test_every_size_gives_a_picture_with_a_legend_below(tiny, size):
    rgb = np.zeros((*size, 3), np.uint8)
    rgb[size[0] // 2 :, :, 1] = 200
    overlay = draw_overlay(tiny.predict(rgb))
    assert overlay.mode == "RGB"
    assert overlay.width <= LONGEST_PX
    assert overlay.width >= 300
    if size[0] < 4 * size[1]:  # towers have margins
        assert overlay.width >= NARROWEST_PX
        assert overlay.height > round(size[0] * overlay.width / size[1]) + 30


def test_a_picture_within_the_bounds_keeps_its_pixels_where_there_is_no_ground(tiny):
    rgb = np.random.default_rng(0).integers(0, 40, (300, 600, 3), np.uint8)
    overlay = np.asarray(draw_overlay(tiny.predict(rgb)))
    assert overlay.shape[1] == 600
    np.testing.assert_array_equal(overlay[:300], rgb)


@pytest.fixture
def halves(tiny):
    """Left half visible ground, right half hidden ground, on a grey picture."""
    prediction = tiny.predict(np.full((300, 600, 3), 128, np.uint8))
    left = np.zeros(prediction.map_size, np.float32)
    left[:, : left.shape[1] // 2] = 1
    return prediction.with_maps(
        visible_ground_probability=left,
        ground_probability=np.ones_like(left),
        unmasked_ground_depth_m=np.full_like(left, 4.0),
    )


def test_hidden_ground_differs_by_pattern_not_only_by_colour(halves):
    grey = np.asarray(draw_overlay(halves).convert("L"), float)[:300]
    visible, hidden = grey[20:280, 20:280], grey[20:280, 320:580]
    assert visible.std() < 1
    assert hidden.std() > 10


@pytest.mark.parametrize("grey", [0, 90, 255])
def test_visible_ground_has_the_tint_of_its_distance_up_to_its_outline(halves, grey):
    """Far from outlines a table gives the colour, near to them arithmetic."""
    picture = replace(halves.picture, pixels=np.full((300, 600, 3), grey, np.uint8))
    ramp = np.geomspace(0.4, 25, halves.map_size[1], dtype=np.float32)
    depth_m = np.resize(ramp, halves.map_size)
    everywhere = np.ones_like(depth_m)
    everywhere[:, -halves.map_size[1] // 4 :] = 0
    prediction = replace(halves, picture=picture).with_maps(
        visible_ground_probability=everywhere,
        ground_probability=everywhere,
        unmasked_ground_depth_m=depth_m,
    )
    drawn = np.asarray(draw_overlay(prediction))[150, :440].astype(float)
    columns = (np.arange(440) + 0.5) * halves.map_size[1] / 600 - 0.5
    inverse_m = np.interp(columns, np.arange(halves.map_size[1]), 1 / depth_m[0])
    expected = TINT * colours_of(1 / inverse_m) + (1 - TINT) * grey
    off = np.abs(drawn - expected).max(axis=1)
    assert (off > 2.5).mean() < 0.25  # isolines
    assert np.median(off) <= 1


def test_the_same_distance_has_the_same_colour_on_any_picture_and_others_another(halves):
    near = halves.with_maps(unmasked_ground_depth_m=np.full(halves.map_size, 1.5, np.float32))
    at_4_m, at_1_5_m = (np.asarray(draw_overlay(p))[150, 100].astype(int) for p in (halves, near))
    assert np.abs(at_4_m - at_1_5_m).max() > 40
    assert at_1_5_m.sum() > at_4_m.sum()  # nearer is lighter
