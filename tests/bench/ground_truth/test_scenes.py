"""Synthetic scenes as ground truth: what the generator knows, as the benchmark sees it."""

import shutil

import numpy as np
import pytest

pytest.importorskip("embreex", reason="scenes are made by ray casting")

from footprints_edge_bench.accuracy.baselines import without_footprints
from footprints_edge_bench.ground_truth.datasets import ReadingOptions, Subset, open_folder
from footprints_edge_models.scenes.make import make_scenes
from footprints_edge_models.scenes.storage.files import SceneSettings

COUNT = 4


@pytest.fixture(scope="module")
def ground_truths(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scenes") / "made"
    settings = SceneSettings("test", 5, (96, 160))
    make_scenes(folder, settings, [], COUNT, 1, lambda _: None)
    (dataset,) = open_folder(folder, ReadingOptions(), Subset())
    assert dataset.kind == "synthetic scenes"
    return [item.load() for item in dataset.items]


def test_every_scene_is_an_image_of_the_benchmark(ground_truths):
    assert len(ground_truths) == COUNT
    for ground_truth in ground_truths:
        assert ground_truth.image.is_file()
        assert ground_truth.intrinsics is not None
        assert ground_truth.visible_ground.valid.all()


def test_visible_ground_is_ground_at_its_own_depth(ground_truths):
    for ground_truth in ground_truths:
        visible = ground_truth.visible_ground.mask
        assert (ground_truth.ground.mask | ~ground_truth.ground.valid)[visible].all()
        scored = visible & ground_truth.ground.mask
        np.testing.assert_allclose(
            ground_truth.visible_depth_m[scored], ground_truth.ground_depth_m[scored], rtol=1e-3
        )


def test_hidden_ground_lies_behind_what_is_seen(ground_truths):
    hidden = 0
    for ground_truth in ground_truths:
        mask = (
            ground_truth.ground.mask
            & ~ground_truth.visible_ground.mask
            & (ground_truth.visible_depth_m > 0)
        )
        assert (
            ground_truth.ground_depth_m[mask] >= 0.99 * ground_truth.visible_depth_m[mask]
        ).all()
        hidden += mask.sum()
    assert hidden > 200


def test_boxes_and_voxels_come_with_the_scenes(ground_truths):
    assert all(
        ground_truth.boxes is not None and ground_truth.voxels is not None
        for ground_truth in ground_truths
    )
    taken = 0
    for ground_truth in ground_truths:
        everything = np.ones(ground_truth.size, bool)
        left = without_footprints(everything, ground_truth.boxes, ground_truth.intrinsics)
        taken += (~left & ground_truth.ground.valid & ~ground_truth.ground.mask).sum()
    assert taken > 0, "no box stands on anything that is not ground"


def test_a_renamed_folder_keeps_its_boxes(scenes, tmp_path):
    renamed = tmp_path / "renamed"
    shutil.copytree(scenes, renamed)
    (before,), (after,) = (
        open_folder(folder, ReadingOptions(), Subset()) for folder in (scenes, renamed)
    )
    for one, other in zip(before.items, after.items, strict=True):
        assert len(one.load().boxes) == len(other.load().boxes) > 0
