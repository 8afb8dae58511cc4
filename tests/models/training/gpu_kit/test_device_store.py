"""The store of views: what goes in comes out, it grows, and old views make room."""

import numpy as np
import pytest
import torch

from footprints_edge_models import sample as labels_of_samples
from footprints_edge_models.training.gpu_kit.device_store import DeviceStore
from footprints_edge_models.training.gpu_kit.stored_view import (
    GROUND_CODES,
    VISIBLE_CODES,
    StoredView,
    as_sample,
    stored_view,
)

CPU = torch.device("cpu")


def view(value, size=(4, 6)):
    return StoredView(
        np.full((*size, 4), value, np.uint8), np.full((*size, 2), value, np.float16), (1, 2, 3, 4)
    )


def values(store, numbers):
    return store.batch(np.array(numbers)).pixels[:, 0].contiguous().view(torch.uint8)[::4].tolist()


def test_a_sample_survives_storing_and_the_way_between_processes(sample):
    each = sample(3)
    back = as_sample(StoredView.from_bytes(stored_view(each, 10_000).to_bytes()), each.name)
    for name in ("image", "visible_ground", "ground", "moving", "visible_depth_m"):
        assert np.array_equal(getattr(back, name), getattr(each, name)), name
    assert np.array_equal(back.ground_depth_m, each.ground_depth_m)
    assert back.intrinsics == each.intrinsics


def test_every_label_that_there_is_can_be_stored():
    names = ("NO", "YES", "UNSEEN", "FOOTPRINT", "UNLIKELY", "UNKNOWN")
    labels = {value for name, value in vars(labels_of_samples).items() if name in names}
    assert labels == set(GROUND_CODES)
    assert set(VISIBLE_CODES) < labels


def test_a_large_sample_is_shrunk_and_its_camera_with_it(sample):
    each = sample(3)
    small = stored_view(each, 1500)
    assert small.size[0] * small.size[1] <= 1500
    assert small.intrinsics[0] == pytest.approx(each.intrinsics.fx * small.size[1] / 96, rel=0.03)


def test_the_store_grows_block_by_block():
    store = DeviceStore(CPU, 24, 7, block_views=2)
    for value in range(7):
        assert store.add(view(value), "made", may_go=False)
    assert len(store) == 7
    assert values(store, [6, 0, 3]) == [6, 0, 3]
    assert not store.add(view(9), "made", may_go=False)


def test_the_oldest_view_that_may_go_makes_room():
    store = DeviceStore(CPU, 24, 3)
    store.add(view(1), "photos", may_go=False)
    for value in (2, 3, 4, 5):
        assert store.add(view(value), "scenes", may_go=True)
    assert sorted(values(store, [0, 1, 2])) == [1, 4, 5]
    assert store.replaced == 2
    assert {name: len(views) for name, views in store.datasets.items()} == {
        "photos": 1,
        "scenes": 2,
    }


def test_views_of_any_shape_share_a_store():
    store = DeviceStore(CPU, 24, 2)
    store.add(view(1, (4, 6)), "made", may_go=False)
    store.add(view(2, (5, 3)), "made", may_go=False)
    assert store.batch(np.array([1, 0])).sizes.tolist() == [[5, 3], [4, 6]]
    with pytest.raises(ValueError, match="24 pixels"):
        store.add(view(3, (5, 5)), "made", may_go=False)


def test_data_sets_are_drawn_by_their_shares():
    store = DeviceStore(CPU, 24, 11)
    store.add(view(1), "few", may_go=False)
    for _ in range(9):
        store.add(view(2), "many", may_go=False)
    store.add(view(3), "never", may_go=False)
    drawn = store.draw(2000, {"few": 0.3, "many": 0.1}, np.random.default_rng(0))
    assert set(drawn) <= set(range(10))
    assert np.mean(drawn == 0) == pytest.approx(0.75, abs=0.04)
