"""Packed datasets: the samples that went in come out, to any number of processes."""

from dataclasses import fields

import numpy as np
import pytest

from footprints_edge.errors import FootprintsError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.data.packed import is_packed, load_packed, pack
from footprints_edge_models.sample import Sample
from footprints_edge_models.training.batches import BatchPlan, make_batch


def sample(index, *, depth=True):
    rng = np.random.default_rng(index)
    size = (40, 60 + index)
    label = rng.integers(0, 2, size).astype(np.uint8)
    depth_m = rng.uniform(1, 9, size).astype(np.float16) if depth else None
    return Sample(
        f"made/{index}",
        rng.integers(0, 256, (*size, 3)).astype(np.uint8),
        Intrinsics(50.0, 51.0, 30.0, 20.0),
        label,
        1 - label,
        depth_m,
        ground_depth_m=depth_m,
        moving=None if depth else label,
    )


@pytest.fixture
def datasets():
    return {
        "made": TrainingDataset([sample(0), sample(1)], [sample(2)], 0.7),
        "photos": TrainingDataset([sample(3, depth=False)], [], 0.3),
    }


def same(one, other):
    for field in fields(Sample):
        found, expected = getattr(one, field.name), getattr(other, field.name)
        if isinstance(expected, np.ndarray):
            assert found.dtype == expected.dtype
            np.testing.assert_array_equal(found, expected)
        else:
            assert found == expected, field.name


def test_what_went_in_comes_out(datasets, tmp_path):
    assert not is_packed(tmp_path)
    assert pack(datasets, tmp_path) == [tmp_path / "made.json", tmp_path / "photos.json"]
    assert is_packed(tmp_path)
    packed = load_packed(tmp_path)
    assert packed.keys() == datasets.keys()
    for name, dataset in datasets.items():
        assert packed[name].share == dataset.share
        for part in ("train", "held_out"):
            found, expected = getattr(packed[name], part), getattr(dataset, part)
            assert len(found) == len(expected)
            for index, one in enumerate(expected):
                same(found[index], one)
    assert [one.name for one in packed["made"].train[1:]] == ["made/1"]
    assert len(packed["made"].train[::5]) == 1


def test_training_sees_the_same_batches(datasets, tmp_path):
    pack(datasets, tmp_path)
    plan = BatchPlan(lambda _: (32, 64), lambda _: 400.0, 3, 0)
    (images, targets), (same_images, same_targets) = (
        make_batch(some, plan, 5) for some in (datasets, load_packed(tmp_path))
    )
    np.testing.assert_array_equal(images, same_images)
    np.testing.assert_array_equal(targets.ground_depth_m, same_targets.ground_depth_m)


class Damaged(list):
    """Samples of which one cannot be read."""

    def __getitem__(self, index):
        if index == 0:
            raise FootprintsError("made/0: not a picture")
        return super().__getitem__(index)


def test_a_sample_that_cannot_be_read_is_left_out(datasets, tmp_path, caplog):
    train = Damaged(datasets["made"].train)
    pack({"made": TrainingDataset(train, [], 1.0)}, tmp_path)
    assert [one.name for one in load_packed(tmp_path)["made"].train] == ["made/1"]
    assert "left out: made/0" in caplog.text


def test_an_interrupted_command_goes_on_with_the_next_dataset(datasets, tmp_path):
    first, second = datasets
    pack({first: datasets[first]}, tmp_path)
    before = (tmp_path / f"{first}.bin").stat().st_mtime_ns
    pack(datasets, tmp_path)
    assert (tmp_path / f"{first}.bin").stat().st_mtime_ns == before
    assert load_packed(tmp_path).keys() == {first, second}


@pytest.mark.parametrize("damage", ["{", '{"version": 1}', '{"version": 99, "share": 1}'])
def test_a_damaged_index_says_so(datasets, tmp_path, damage):
    pack(datasets, tmp_path)
    (tmp_path / "made.json").write_text(damage)
    with pytest.raises(DatasetError, match=r"made\.json: damaged"):
        load_packed(tmp_path)


def test_a_file_that_is_too_short_says_so(datasets, tmp_path):
    pack(datasets, tmp_path)
    content = (tmp_path / "made.bin").read_bytes()
    (tmp_path / "made.bin").write_bytes(content[:-100])
    with pytest.raises(DatasetError, match=r"made\.json: damaged"):
        load_packed(tmp_path)
