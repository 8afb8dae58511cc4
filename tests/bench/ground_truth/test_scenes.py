"""Made scenes as truth: what the generator knows, as the benchmark sees it."""

import numpy as np
import pytest

pytest.importorskip("embreex", reason="scenes are made by ray casting")

from footprints_edge_bench.accuracy.baselines import without_footprints
from footprints_edge_bench.ground_truth.datasets import Part, Reading, open_dataset
from footprints_edge_models.scenes.make import make_scenes
from footprints_edge_models.scenes.storage.files import SceneSettings

COUNT = 4


@pytest.fixture(scope="module")
def truths(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scenes") / "made"
    settings = SceneSettings("test", 5, (96, 160))
    make_scenes(folder, settings, [], COUNT, 1, lambda _: None)
    dataset = open_dataset(folder, Reading(), Part())
    assert dataset.kind == "made scenes"
    return [item.load() for item in dataset.items]


def test_every_scene_is_an_image_of_the_benchmark(truths):
    assert len(truths) == COUNT
    for truth in truths:
        assert truth.image.is_file()
        assert truth.intrinsics is not None
        assert truth.visible_ground.known.all()


def test_visible_ground_is_ground_at_its_own_depth(truths):
    for truth in truths:
        visible = truth.visible_ground.mask
        assert (truth.ground.mask | ~truth.ground.known)[visible].all()
        scored = visible & truth.ground.mask
        np.testing.assert_allclose(
            truth.visible_depth_m[scored], truth.ground_depth_m[scored], rtol=1e-3
        )


def test_hidden_ground_lies_behind_what_is_seen(truths):
    hidden = 0
    for truth in truths:
        mask = truth.ground.mask & ~truth.visible_ground.mask & (truth.visible_depth_m > 0)
        assert (truth.ground_depth_m[mask] >= 0.99 * truth.visible_depth_m[mask]).all()
        hidden += mask.sum()
    assert hidden > 200


def test_boxes_and_voxels_come_with_the_scenes(truths):
    assert all(truth.boxes is not None and truth.voxels is not None for truth in truths)
    taken = 0
    for truth in truths:
        everything = np.ones(truth.size, bool)
        left = without_footprints(everything, truth.boxes, truth.intrinsics)
        taken += (~left & truth.ground.known & ~truth.ground.mask).sum()
    assert taken > 0, "no box stands on anything that is not ground"
