import numpy as np
import pytest

from footprints_edge.drawing.colormap import (
    colour_scale,
    colours_of,
    scale_in_oklab,
    scale_position,
)


def linear_rgb(srgb):
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)


def oklab(rgb):
    """Ottosson's forward transform, from his matrices from linear sRGB."""
    to_lms = [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
    to_lab = [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
    return np.cbrt(linear_rgb(rgb / 255) @ np.transpose(to_lms)) @ np.transpose(to_lab)


def test_the_colours_are_the_oklab_path_without_clipping():
    np.testing.assert_allclose(oklab(colour_scale()), scale_in_oklab(), atol=0.006)


def test_equal_steps_and_falling_lightness():
    steps = np.diff(scale_in_oklab(), axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    assert lengths.max() < 1.01 * lengths.min()
    assert (steps[:, 0] < 0).all()


def test_equal_ratios_of_distance_are_equal_steps():
    position = scale_position(np.float32([0.5, 20, 1, 2, 4, 8]))
    assert list(position[:2]) == [0, 255]
    np.testing.assert_allclose(np.diff(position[2:]), 255 * np.log(2) / np.log(40), atol=1)


@pytest.mark.parametrize(("beyond", "end"), [(0.1, 0.5), (500, 20), (np.nan, 20), (np.inf, 20)])
def test_beyond_the_ends_is_the_ends_colour(beyond, end):
    np.testing.assert_array_equal(colours_of(np.float32(beyond)), colours_of(np.float32(end)))
