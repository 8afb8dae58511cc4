"""Copy-paste augmentation on two made-up street photos with exact ground truth."""

import numpy as np
import pytest

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.data.copy_paste import (
    CAMERA_HEIGHT_M,
    CopyPastePhotos,
    CutoutClass,
    LabelledPhoto,
    cut_out,
    paste,
)
from footprints_edge_models.sample import FOOTPRINT, NO, UNKNOWN, YES, Sample

SIZE = (200, 300)
HORIZON = 80
ROAD, SKY, PERSON, CAR = 0, 6, 2, 3
KINDS = (CutoutClass(PERSON, 0.4, 0.8), CutoutClass(CAR, 1.6, 5.0))


def street(*things):
    """A photo with sky above row 80, road below, and things (id, row0, row1, column0, column1)."""
    ids = np.full(SIZE, ROAD, np.uint8)
    ids[:HORIZON] = SKY
    image = np.where(ids[..., None] == SKY, 200, 90).astype(np.uint8).repeat(3, axis=2)
    for label, top, bottom, left, right in things:
        ids[top:bottom, left:right] = label
        image[top:bottom, left:right] = (250, 20, 20)
    visible = np.where(ids == ROAD, YES, NO).astype(np.uint8)
    ground = np.where(ids == ROAD, YES, np.where(ids == SKY, NO, UNKNOWN)).astype(np.uint8)
    sample = Sample("street", image, Intrinsics.assumed(SIZE), visible, ground)
    return LabelledPhoto(sample, ids, HORIZON)


@pytest.fixture
def walker():
    (cutout,) = cut_out(street((PERSON, 60, 140, 100, 125)), KINDS)
    return cutout


def test_a_person_is_cut_out_whole(walker):
    assert walker.mask.shape == (80, 25)
    assert walker.mask.all()
    assert (walker.image == (250, 20, 20)).all()
    assert walker.rows_below_horizon == 139 - HORIZON


@pytest.mark.parametrize(
    ("thing", "why"),
    [
        ((PERSON, 60, 140, 0, 25), "cut off by the border"),
        ((PERSON, 110, 130, 100, 108), "too small"),
        ((CAR, 40, 76, 100, 140), "not on the ground"),
    ],
)
def test_parts_specks_and_floating_things_are_left(thing, why):
    assert cut_out(street(thing), KINDS) == [], why


@pytest.fixture
def composed(walker):
    empty = street()
    for seed in range(20):
        result = paste(empty, walker, [PERSON, CAR], np.random.default_rng(seed))
        if result is not None:
            return empty, result
    raise AssertionError("never found room on an empty road")


def test_size_follows_from_the_distance(composed):
    _, result = composed
    rows, columns = np.nonzero(result.ids == PERSON)
    scale = (rows.max() - HORIZON) / (139 - HORIZON)
    assert rows.max() - rows.min() + 1 == pytest.approx(80 * scale, abs=3)
    assert columns.max() - columns.min() + 1 == pytest.approx(25 * scale, abs=3)


def test_what_it_covers_is_hidden_ground_and_its_feet_are_a_footprint(composed):
    empty, result = composed
    thing = result.ids == PERSON
    assert (result.sample.visible_ground[thing] == NO).all()
    rows = np.arange(SIZE[0])[:, None] + np.zeros(SIZE)
    foot = np.nonzero(thing)[0].max()
    scale = result.sample.intrinsics.focal_px * CAMERA_HEIGHT_M
    with np.errstate(divide="ignore"):
        behind_m = np.where(rows > HORIZON, scale / (rows - HORIZON), np.inf) - scale / (
            foot - HORIZON
        )
    on_road = thing & (rows >= HORIZON)
    ground = result.sample.ground
    assert (ground[on_road & (behind_m < 0.3)] == FOOTPRINT).all()
    assert (ground[on_road & (behind_m > 1.0)] == YES).all()
    assert (ground[on_road & (behind_m > 1.0)] == YES).sum() > 50
    assert (ground[thing & (rows < HORIZON)] == NO).all()  # the sky stays what it was
    # elsewhere nothing is known now that was not before, but around its border
    far = ~thing & (result.sample.visible_ground != UNKNOWN)
    np.testing.assert_array_equal(ground[far], empty.sample.ground[far])
    np.testing.assert_array_equal(
        result.sample.visible_ground[far], empty.sample.visible_ground[far]
    )


def test_the_photo_is_changed_around_the_thing_only_and_never_in_place(composed):
    empty, result = composed
    assert (street().sample.image == empty.sample.image).all()
    changed = (result.sample.image != empty.sample.image).any(axis=-1)
    rows, columns = np.nonzero(result.ids == PERSON)
    height = rows.max() - rows.min() + 1
    near = np.zeros(SIZE, bool)
    reach = round(0.4 * height)
    near[
        max(0, rows.min() - reach) : rows.max() + reach,
        max(0, columns.min() - reach) : columns.max() + reach,
    ] = True
    assert changed[result.ids == PERSON].mean() > 0.95
    assert not (changed & ~near).any()


def test_nothing_is_set_down_behind_a_nearer_thing(walker):
    crowded = street((CAR, 90, 200, 0, 300))
    for seed in range(20):
        assert paste(crowded, walker, [PERSON, CAR], np.random.default_rng(seed)) is None


def test_an_index_is_always_the_same_picture():
    photos = [street((PERSON, 60, 140, 100, 125)), street((CAR, 90, 150, 150, 230)), street()]
    first, second = CopyPastePhotos(photos, KINDS, seed=1), CopyPastePhotos(photos, KINDS, seed=1)
    assert len(first) == 3
    for index in (2, 0, 1):
        np.testing.assert_array_equal(first[index].image, second[index].image)
        np.testing.assert_array_equal(first[index].ground, second[index].ground)
    other = CopyPastePhotos(photos, KINDS, seed=2)
    assert any((other[i].image != first[i].image).any() for i in range(3))
    assert len(list(first)) == 3
    assert len(CopyPastePhotos([street()], KINDS, seed=0)) == 0
