"""Labelled photos on tiny trees: what a class id means for visible and hidden ground."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.readers.labelled_photos import PhotoLabels, read_photos
from footprints_edge_models.sample import NO, UNKNOWN, UNLIKELY, YES

ROAD, WALL, PERSON, SKY, VOID = 1, 2, 3, 4, 9
LABELS = PhotoLabels(walkable=(ROAD,), void=(VOID,), barriers=(WALL,), sky=(SKY,))


@pytest.fixture
def street_ids():
    """Sky on top, walls below it, road at the bottom; a person and a void on the road."""
    ids = np.full((50, 80), SKY, np.uint8)
    ids[10:30] = WALL
    ids[30:] = ROAD
    ids[20:45, 10:15] = PERSON
    ids[40:, 60:70] = VOID
    return ids


def test_a_labelled_photo(write_photo, tmp_path, street_ids):
    write_photo(tmp_path / "street", "a", street_ids)
    (sample,) = read_photos(tmp_path / "street", LABELS)
    assert sample.image.shape == (50, 80, 3)
    assert sample.intrinsics == Intrinsics.assumed((50, 80))
    assert sample.visible_depth_m is None
    assert sample.ground_depth_m is None

    road, void = street_ids == ROAD, street_ids == VOID
    assert (sample.visible_ground[road] == YES).all()
    assert (sample.visible_ground[void] == UNKNOWN).all()
    assert (sample.visible_ground[~road & ~void] == NO).all()

    assert (sample.ground[road] == YES).all()
    assert (sample.ground[street_ids == SKY] == NO).all()
    assert (sample.ground[void] == UNKNOWN).all()
    assert (sample.ground[street_ids == PERSON] == UNKNOWN).all()  # who knows what is behind
    # A wall hides no ground far above the highest that is seen; near it, nobody knows.
    wall = street_ids == WALL
    assert (sample.ground[:27][wall[:27]] == NO).all()
    assert (sample.ground[29][wall[29]] == UNKNOWN).all()


@pytest.fixture
def walled_ids():
    """Road below row 30; on it a wall from the left, a low wall with road behind it, and a post."""
    ids = np.full((60, 100), SKY, np.uint8)
    ids[30:] = ROAD
    ids[25:50, :30] = WALL
    ids[40:50, 50:80] = WALL
    ids[20:45, 90:94] = WALL
    return ids


def test_behind_a_wall_ground_is_unlikely(write_photo, tmp_path, walled_ids):
    write_photo(tmp_path / "street", "a", walled_ids)
    labels = replace(LABELS, solid=(WALL,))
    (sample,) = read_photos(tmp_path / "street", labels)
    assert (sample.ground[30:50, :30] == UNLIKELY).all()
    assert (sample.visible_ground[30:50, :30] == NO).all()
    # ground is seen farther away, or goes on to both sides
    assert (sample.ground[40:50, 50:80] == UNKNOWN).all()
    assert (sample.ground[30:45, 90:94] == UNKNOWN).all()
    np.testing.assert_array_equal(sample.ground == YES, walled_ids == ROAD)
    (without,) = read_photos(tmp_path / "street", LABELS)
    np.testing.assert_array_equal(
        np.where(sample.ground == UNLIKELY, UNKNOWN, sample.ground), without.ground
    )


def test_a_wall_says_nothing_where_no_ground_is_seen(write_photo, tmp_path):
    ids = np.full((40, 60), WALL)
    ids[:5] = SKY
    write_photo(tmp_path / "wall", "a", ids)
    (sample,) = read_photos(tmp_path / "wall", replace(LABELS, solid=(WALL,)))
    assert (sample.ground[5:] == UNKNOWN).all()
    assert (sample.ground[:5] == NO).all()
    assert (sample.visible_ground == NO).all()


def test_a_large_photo_is_shrunk_with_its_labels_and_camera(write_photo, tmp_path):
    ids = np.full((600, 1024), WALL)
    ids[300:] = ROAD
    image = np.zeros((600, 1024, 3), np.uint8)
    image[300:] = 200
    write_photo(tmp_path / "big", "a", ids, image)
    (sample,) = read_photos(tmp_path / "big", LABELS)
    assert sample.image.shape == (300, 512, 3)
    assert (sample.visible_ground[:150] == NO).all()
    assert (sample.visible_ground[150:] == YES).all()
    assert sample.image[:145].max() < 60
    assert sample.image[155:].min() > 150
    # A camera's field of view does not change when its picture is resized.
    before = Intrinsics.assumed((600, 1024)).hfov_deg((600, 1024))
    assert sample.intrinsics.hfov_deg((300, 512)) == pytest.approx(before)


def test_labels_of_another_size_are_named(write_photo, tmp_path, street_ids):
    write_photo(tmp_path / "street", "a", street_ids)
    Image.fromarray(street_ids[:-1]).save(tmp_path / "street" / "labels" / "a.png")
    with pytest.raises(DatasetError, match=r"labels.a\.png.*\(49, 80\).*\(50, 80\)"):
        list(read_photos(tmp_path / "street", LABELS))


def test_coloured_labels_are_refused(write_photo, tmp_path, street_ids):
    write_photo(tmp_path / "street", "a", street_ids)
    colours = np.zeros((50, 80, 3), np.uint8)
    Image.fromarray(colours).save(tmp_path / "street" / "labels" / "a.png")
    with pytest.raises(DatasetError, match=r"labels.a\.png"):
        list(read_photos(tmp_path / "street", LABELS))


def test_a_missing_label_picture_is_named(write_photo, tmp_path, street_ids):
    write_photo(tmp_path / "street", "a", street_ids)
    (tmp_path / "street" / "labels" / "a.png").unlink()
    with pytest.raises(DatasetError, match=r"labels.a\.png"):
        list(read_photos(tmp_path / "street", LABELS))


def test_a_missing_folder_of_pictures_is_named(tmp_path):
    with pytest.raises(DatasetError, match=r"images: no such folder"):
        list(read_photos(tmp_path, LABELS))
