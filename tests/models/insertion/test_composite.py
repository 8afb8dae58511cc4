"""A box put on the floor of a photo: where it stands and what it hides follow from the camera."""

import cv2
import numpy as np
import pytest

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.insertion.composite import compose
from footprints_edge_models.insertion.labels import InsertedLabels, decoded
from footprints_edge_models.insertion.photo_floor import InsertionError, PhotoFloor
from footprints_edge_models.insertion.standing import place_things
from footprints_edge_models.scenes.assets.materials import Material, Palette
from footprints_edge_models.scenes.assets.textures.library import TextureKey, TextureLibrary
from footprints_edge_models.scenes.assets.things import box, joined
from footprints_edge_models.scenes.rendering.cameras import Camera, looking

SIZE = (120, 160)
WALL, FLOOR = 1, 4
CAMERA = Camera(
    np.array([0.0, 0.0, 1.5]),
    looking(np.pi / 2, np.radians(20), 0.0),
    Intrinsics.from_hfov(70, SIZE),
    SIZE,
)
WALL_ROWS = 40
"""The floor ends at a wall: 6.5 m ahead."""


@pytest.fixture
def floor():
    """A photo of grey floor and a lighter wall, with the noise of a camera."""
    rng = np.random.default_rng(0)
    image = np.full((*SIZE, 3), 110, np.uint8)
    image[:WALL_ROWS] = 190
    image += rng.integers(0, 6, image.shape, np.uint8)
    ids = np.full(SIZE, FLOOR, np.uint8)
    ids[:WALL_ROWS] = WALL
    return PhotoFloor(image, ids, ids == FLOOR, CAMERA, outdoors=False)


def crate(side_m, x, y):
    """A cube, its middle on (x, y)."""
    material = Material(TextureKey("blank", 0), 1.0, (0.9, 0.2, 0.2))
    return joined("crate", [box(material, (side_m,) * 3, (0, 0, 0))]).at(x, y)


def pixel(x, y, z=0.0):
    """Row and column of a point in the world."""
    right, down, ahead = (np.array([x, y, z]) - CAMERA.position_m) @ CAMERA.rotation
    k = CAMERA.intrinsics
    return int(k.fy * down / ahead + k.cy), int(k.fx * right / ahead + k.cx)


def composite(floor, *things, seed=0):
    library = TextureLibrary("train")
    return compose(floor, things, library, np.random.default_rng(seed))


def test_a_crate_takes_floor_and_hides_floor(floor):
    made = composite(floor, crate(0.6, 0.0, 3.0))
    labels = made.labels
    assert labels.shows_model[pixel(0, 2.7, 0.3)]  # its front
    assert labels.taken[pixel(0, 3.0)]  # below its middle
    assert labels.taken[pixel(0.25, 2.8)] and not labels.taken[pixel(0.36, 3.0)]
    behind = pixel(0, 3.5)
    assert labels.shows_model[behind] and not labels.taken[behind]
    assert labels.ids[behind] == FLOOR  # floor that the crate hides
    free = pixel(1.2, 3.0)
    assert not labels.shows_model[free] and not labels.taken[free]
    # as high as the camera sees it, no higher
    assert not labels.shows_model[pixel(0, 3.3, 0.75)]


def test_the_photo_stays_what_it_was_away_from_the_crate(floor):
    made = composite(floor, crate(0.6, 0.0, 3.0))
    changed = np.abs(made.image.astype(int) - floor.image).max(axis=2)
    away = np.ones(SIZE, bool)
    rows, columns = np.nonzero(made.labels.shows_model)
    away[rows.min() - 3 : rows.max() + 4, columns.min() - 3 : columns.max() + 4] = False
    assert changed[:WALL_ROWS][away[:WALL_ROWS]].max() <= 1
    shows = made.labels.shows_model
    red, green = (made.image[..., channel][shows].mean() for channel in (0, 1))
    assert red > 1.3 * green
    # its shadow falls on the floor beside it, and nowhere is the floor brighter than it was
    beside = away[WALL_ROWS:]
    difference = made.image[WALL_ROWS:].astype(int) - floor.image[WALL_ROWS:]
    assert difference[beside].max() <= 6
    assert difference.min() < -6


def test_what_fills_too_little_is_refused(floor):
    with pytest.raises(InsertionError, match="small"):
        composite(floor, crate(0.05, 0.0, 5.0))


def test_things_stand_on_the_floor_that_is_seen(floor):
    mask = floor.mask.copy()
    mask[:, SIZE[1] // 2 :] = False
    half = PhotoFloor(floor.image, floor.ids, mask, CAMERA, outdoors=False)
    placed = [
        thing
        for seed in range(4)
        for thing in place_things(
            half, Palette(TextureLibrary("train"), np.random.default_rng(seed))
        )
    ]
    assert placed
    for thing in placed:
        for outline in thing.footprints():
            assert np.mean(outline[:, 0] < 0.05) > 0.9  # left of the camera's axis


def test_hardly_anything_on_the_floor_stands_between_the_legs_of_a_thing(floor):
    rng = np.random.default_rng(0)
    mask = floor.mask.copy()
    for row, column in zip(rng.integers(WALL_ROWS, 115, 20), rng.integers(0, 155, 20), strict=True):
        mask[row : row + 6, column : column + 6] = False  # things that the photo shows
    crowded = PhotoFloor(floor.image, floor.ids, mask, CAMERA, outdoors=False)
    placed = 0
    for seed in range(12):
        palette = Palette(TextureLibrary("train"), np.random.default_rng(seed))
        for thing in place_things(crowded, palette):
            corners = np.concatenate(thing.footprints())
            place = np.array([pixel(x, y)[::-1] for x, y in corners], np.int32)
            hull = cv2.fillConvexPoly(np.zeros(SIZE, np.uint8), cv2.convexHull(place), 1) > 0
            placed += 1
            assert mask[hull].mean() > 0.85
    assert placed > 3


def test_labels_come_back_from_their_picture():
    rng = np.random.default_rng(1)
    ids = rng.integers(0, 31, SIZE).astype(np.uint8)
    shows = rng.random(SIZE) < 0.5
    taken = rng.random(SIZE) < 0.2
    ids[taken] = FLOOR
    back = decoded(InsertedLabels(ids, shows, taken).encoded(), FLOOR)
    np.testing.assert_array_equal(back.ids, ids)
    np.testing.assert_array_equal(back.taken, taken)
    np.testing.assert_array_equal(back.shows_model, shows | taken)
