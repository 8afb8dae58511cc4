"""What the scores of a benchmark depend on."""

import os

import numpy as np
import pytest

from footprints_edge.model import load
from footprints_edge_bench.accuracy.benchmark import (
    AccuracyError,
    BaselineInputs,
    Benchmark,
    name_models,
    open_benchmark,
)
from footprints_edge_bench.ground_truth.base import EvaluationDataset, Item
from footprints_edge_bench.ground_truth.datasets import Subset


def changed(before, after):
    return {key for key in before if before[key] != after[key]}


def touch(path):
    os.utime(path, ns=(10**18, path.stat().st_mtime_ns + 10**9))


def test_ground_truth_files_count_and_images_do_not(clip, green_is_ground):
    def settings():
        return open_benchmark([clip], Subset.parse("0:0.5"), [str(green_is_ground)]).settings()

    before = settings()
    assert settings() == before
    touch(clip / "images" / "f0.jpg")
    assert settings() == before
    touch(clip / "depth" / "f9.png")  # of a frame that is not scored, but in the floor map
    assert changed(before, settings()) == {"ground_truth"}


def test_voxel_files_count_by_what_they_are_not_where(tmp_path, green_is_ground):
    models = {"green": load(green_is_ground)}
    datasets = (EvaluationDataset("a", "clip", (Item("a/x", None), Item("a/y", None))),)

    def settings(folder):
        return Benchmark(datasets, models, BaselineInputs(voxels=folder)).settings()

    (tmp_path / "one" / "a").mkdir(parents=True)
    np.savez(tmp_path / "one" / "a" / "x.npz", labels=np.zeros(3))
    before = settings(tmp_path / "one")
    moved = (tmp_path / "one").rename(tmp_path / "two")
    assert settings(moved) == before
    np.savez(moved / "a" / "y.npz", labels=np.zeros(3))
    with_y = settings(moved)
    assert changed(before, with_y) == {"voxels"}
    touch(moved / "a" / "x.npz")
    assert changed(with_y, settings(moved)) == {"voxels"}
    assert changed(before, settings(None)) == {"voxels"}


def test_models_of_one_name_are_refused(green_is_ground):
    model = load(green_is_ground)
    with pytest.raises(AccuracyError, match="two models"):
        name_models([model, model])
