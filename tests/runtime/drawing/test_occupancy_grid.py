"""The bird's-eye view as a picture, and beside the overlay."""

from dataclasses import replace

import numpy as np
import pytest
from predictions import make_prediction

from footprints_edge.drawing.colormap import colours_of
from footprints_edge.drawing.occupancy_grid import (
    bev_layers,
    draw_bev,
    draw_occupancy_grid,
    paint_bev,
)
from footprints_edge.drawing.overlay import LEGEND_PX, draw_overlay
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import DecodedImage
from footprints_edge.navigation.occupancy_grid import HIDDEN, OCCUPIED, UNKNOWN, VISIBLE

ROWS = 40
CELL_M = 0.1


def drawn(cells, height_px=400, **options):
    return np.asarray(draw_occupancy_grid(cells, CELL_M, height_px, **options)).astype(int)


def block(picture, row, column, px=10):
    """The pixels of a cell, without its rim."""
    return picture[row * px + 2 : row * px + px - 2, column * px + 2 : column * px + px - 2]


def test_each_kind_of_cell_is_distinct_and_left_is_left():
    cells = np.full((ROWS, 2 * ROWS), UNKNOWN, np.uint8)
    cells[5:9, 10:14] = VISIBLE
    cells[5:9, 60:66] = HIDDEN
    cells[20:24, 20:24] = OCCUPIED
    picture = drawn(cells)
    assert picture.shape == (400, 800, 3)
    x_m, y_m = (ROWS - 6 - 0.5) * CELL_M, (ROWS - 11 - 0.5) * CELL_M
    expected = colours_of(np.float32([np.hypot(x_m, y_m)]))[0].astype(int)
    assert np.abs(block(picture, 6, 11) - expected).max() < 12
    hidden = picture[52:88, 602:658].reshape(-1, 3)
    grey = (hidden == 70).all(axis=1).mean()
    assert 0.3 < grey < 0.7  # the stripes of the hatching
    occupied, unknown = block(picture, 21, 21), block(picture, 30, 5)
    assert occupied.max() < 20 < unknown.min() < unknown.max() < 70


def test_a_square_picture_shows_the_middle():
    cells = np.full((ROWS, 2 * ROWS), UNKNOWN, np.uint8)
    cells[:, ROWS - 1 : ROWS + 1] = OCCUPIED  # straight ahead
    picture = drawn(cells, square=True)
    assert picture.shape == (400, 400, 3)
    assert block(picture, 8, 19).max() < 20 < block(picture, 8, 10).min()


@pytest.fixture
def prediction():
    """A level floor 1.5 m below the camera."""
    camera = Intrinsics(100, 100, 63.5, 20.0)
    depth_m = 1.5 / (np.cos(0.35) * (np.arange(96) - 20) / 100 + np.sin(0.35))
    depth_m = np.repeat(depth_m.astype(np.float32)[:, None], 128, 1)
    picture = np.full((360, 480, 3), 90, np.uint8)
    return make_prediction(depth_m, intrinsics=camera, picture=picture)


def test_the_bev_stands_beside_an_overlay_that_stays_as_it_is(prediction):
    plain, wide = (np.asarray(draw_overlay(prediction, bev=on)) for on in (False, True))
    height, width = plain.shape[:2]
    assert wide.shape == (height, width + height, 3)
    np.testing.assert_array_equal(wide[:, :width], plain)
    ahead = wide[round(0.6 * height), width + height // 2].astype(int)  # 4 m ahead there is floor
    assert np.abs(ahead - colours_of(np.float32([4.0]))[0]).max() < 25


def test_frames_have_the_bev_of_pictures(prediction):
    hidden = np.ones((96, 128), np.float32)
    hidden[:, 40:90] = 0
    none = prediction.with_maps(ground_probability=np.zeros((96, 128), np.float32))
    layers = bev_layers(200)
    for each in (prediction, prediction.with_maps(visible_ground_probability=hidden), none):
        drawn = np.asarray(draw_bev(each, 200).convert("RGBA"))
        np.testing.assert_array_equal(paint_bev(each, layers), drawn)


def test_without_a_plane_the_bev_is_unknown(prediction):
    none = prediction.with_maps(ground_probability=np.zeros((96, 128), np.float32))
    panel = np.asarray(draw_overlay(none, bev=True))[:, -200:]
    colourful = np.ptp(panel.astype(int), axis=-1) > 40
    assert not colourful.any()


def test_the_format_writes_it(prediction, tmp_path):
    (path,) = prediction.save(tmp_path, ["topdown_picture"], name="a.jpg")
    assert path.name == "a.jpg.topdown_picture.png"


def test_a_frame_of_one_pixel_is_drawn(prediction):
    pytest.importorskip("cv2")
    from footprints_edge.video.overlay import VideoOverlay

    one = DecodedImage(np.zeros((1, 1, 3), np.uint8))
    assert VideoOverlay().draw(replace(prediction, picture=one)).shape[1] >= LEGEND_PX


@pytest.mark.parametrize("size", [(90, 121), (61, 400)])
def test_a_video_overlay_tints_visible_and_hatches_hidden_ground(prediction, size):
    pytest.importorskip("cv2")
    from footprints_edge.video.overlay import VideoOverlay

    visible, ground = np.zeros((96, 128), np.float32), np.zeros((96, 128), np.float32)
    visible[48:, :42] = 1
    ground[48:, :85] = 1
    rng = np.random.default_rng(0)
    rgb = rng.integers(60, 120, (*size, 3), dtype=np.uint8)
    frame = replace(prediction, picture=DecodedImage(rgb)).with_maps(
        visible_ground_probability=visible, ground_probability=ground
    )
    bgr = VideoOverlay().draw(frame)
    assert bgr.shape[0] % 2 == 0 and bgr.shape[1] % 2 == 0
    height, width = size
    assert bgr.shape[0] > height
    left = (max(width, LEGEND_PX) - width) // 2
    shown = bgr[:height, left : left + width, ::-1].astype(int)
    untouched = (slice(0, height // 2 - 4), slice(None))
    np.testing.assert_array_equal(shown[untouched], rgb[untouched])
    ground_rows = slice(height // 2 + 6, height - 3)
    seen = shown[ground_rows, 5 : width // 3 - 6]
    assert np.ptp(seen.mean(axis=(0, 1))) > 40  # tinted
    hidden = shown[ground_rows, width // 3 + 6 : 2 * width // 3 - 6].astype(float)
    assert hidden.mean(axis=-1).std() > 1.5 * seen.mean(axis=-1).std()  # hatched
