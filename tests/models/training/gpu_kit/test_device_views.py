"""Views cut on the device are those that the trainer cuts on the host."""

from dataclasses import fields

import numpy as np
import pytest
import torch

from footprints_edge_models.data import augmentation
from footprints_edge_models.data.augmentation import render_view
from footprints_edge_models.data.targets import Targets
from footprints_edge_models.training.batches import stack
from footprints_edge_models.training.gpu_kit.device_store import DeviceStore
from footprints_edge_models.training.gpu_kit.device_views import cut_views, draw_cameras
from footprints_edge_models.training.gpu_kit.stored_view import stored_view

CPU = torch.device("cpu")


def stored(samples):
    store = DeviceStore(CPU, 8192, len(samples))
    for each in samples:
        assert store.add(stored_view(each, 8192), "made", may_go=False)
    return store.batch(np.arange(len(samples)))


def cut(batch, size, rng):
    return cut_views(batch, draw_cameras(batch.sizes, batch.intrinsics, size, 70.0, rng), size)


def assert_the_same(ours, theirs):
    """Pictures to OpenCV's precision; labels and depths but for a pixel at some edge."""
    image, targets = ours
    expected, expected_targets = theirs
    expected = expected / 255
    assert image.shape == expected.shape
    assert (image - expected).abs().max() < 2.5 / 255
    for field in fields(Targets):
        mine, known = getattr(targets, field.name), getattr(expected_targets, field.name)
        assert mine.dtype == torch.float32
        assert mine.shape == known.shape
        assert ((mine - known).abs() > 2e-3 * known.abs() + 1e-6).float().mean() < 0.01, field.name


@pytest.mark.parametrize("size", [(64, 96), (96, 64), (64, 64), (128, 160)])
def test_central_views_equal_those_of_the_host(sample, size):
    samples = [sample(seed, shape) for seed, shape in enumerate([(60, 96), (90, 60), (60, 60)])]
    theirs = stack([render_view(each, size, focal_px=70.0) for each in samples])
    assert_the_same(cut(stored(samples), size, None), theirs)


@pytest.mark.parametrize("seed", range(8))
def test_random_views_equal_those_of_the_host_by_the_same_numbers(sample, seed, monkeypatch):
    for name in ("jitter_colours", "degraded"):
        monkeypatch.setattr(augmentation, name, lambda image, _: image, raising=False)
    each, size = sample(seed), [(64, 96), (96, 64)][seed % 2]
    theirs = stack([render_view(each, size, np.random.default_rng(seed), 70.0)])
    assert_the_same(cut(stored([each]), size, np.random.default_rng(seed)), theirs)


def test_random_views_of_one_batch_differ(sample):
    each = sample(0)
    image, _ = cut(stored([each] * 3), (64, 96), np.random.default_rng(0))
    assert (image[0] - image[1]).abs().mean() > 0.01
    assert (image[1] - image[2]).abs().mean() > 0.01


def test_a_view_that_is_shrunk_is_smooth(sample):
    """Stripes of one pixel become grey, not stripes of another width."""
    striped = sample(0)
    striped.image[:] = np.where(np.arange(96) % 2, 255, 0)[None, :, None]
    image, _ = cut(stored([striped]), (32, 32), None)
    assert image.std() < 0.12
