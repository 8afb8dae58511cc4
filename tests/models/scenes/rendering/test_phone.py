"""A phone's camera: what it puts right, and what it leaves."""

import numpy as np
import pytest

from footprints_edge_models.scenes.rendering.phone import take_photo

SIZE = (64, 96)


def light_of(colour, level=1.0):
    """Grey patches of many levels under a coloured light."""
    grey = np.random.default_rng(0).uniform(0.05, 0.8, (8, 12))
    grey = np.kron(grey, np.ones((8, 8))) * level
    return (grey[..., None] * np.array(colour)).astype(np.float32)


def photos(light, count=12):
    return [take_photo(light, np.random.default_rng(seed)).astype(int) for seed in range(count)]


def test_the_same_seed_takes_the_same_photo():
    light = light_of((1, 1, 1))
    first, again, other = (take_photo(light, np.random.default_rng(s)) for s in (1, 1, 2))
    assert (first == again).all() and (first != other).any()
    assert first.shape == (*SIZE, 3) and first.dtype == np.uint8


@pytest.mark.parametrize("colour", [(1.5, 1.0, 0.5), (0.6, 1.0, 1.5)])
def test_most_of_the_lights_colour_is_taken_away(colour):
    cast = np.mean([p[..., 0].mean() - p[..., 2].mean() for p in photos(light_of(colour))])
    naive = (light_of(colour) / 0.8).clip(0, 1) ** (1 / 2.2) * 255
    assert abs(cast) < 0.45 * abs(naive[..., 0].mean() - naive[..., 2].mean())


def test_dim_and_bright_scenes_are_exposed_alike():
    dim, bright = (
        np.mean([p.mean() for p in photos(light_of((1, 1, 1), level))]) for level in (0.02, 5)
    )
    assert dim == pytest.approx(bright, abs=3)
    assert 70 < dim < 180
