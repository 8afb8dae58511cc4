"""Worse cameras: blur along a motion, JPEG, and a picture that is still the same."""

import io

import numpy as np
import pytest
from PIL import Image

from footprints_edge_models.data.degradation import as_jpeg, degraded, motion_kernel


@pytest.mark.parametrize("length_px", [2.0, 5.5, 13.0])
@pytest.mark.parametrize("angle", [0.0, 0.7, np.pi / 2, 2.4])
def test_motion_spreads_a_point_along_its_path(length_px, angle):
    kernel = motion_kernel(length_px, angle)
    assert kernel.sum() == pytest.approx(1, abs=1e-5)
    reach = len(kernel) // 2
    rows, columns = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    along = np.cos(angle) * columns + np.sin(angle) * rows
    across = np.cos(angle) * rows - np.sin(angle) * columns
    assert (kernel * along).sum() == pytest.approx(0, abs=1e-5)
    # an even path of length L has a variance of L^2 / 12; pixels add up to a quarter
    variance = (kernel * along**2).sum()
    assert length_px**2 / 12 <= variance <= length_px**2 / 12 + length_px / 6 + 0.3
    assert (kernel * across**2).sum() < 0.3


def test_jpeg_keeps_the_order_of_the_channels_and_costs_detail():
    rng = np.random.default_rng(0)
    smooth = np.zeros((48, 64, 3), np.uint8)
    smooth[..., 0], smooth[..., 2] = 200, np.linspace(0, 120, 64)
    assert np.abs(as_jpeg(smooth, 90).astype(int) - smooth).mean() < 4
    noisy = rng.integers(0, 256, (48, 64, 3)).astype(np.uint8)
    buffer = io.BytesIO()
    Image.fromarray(noisy).save(buffer, "JPEG", quality=40)
    expected = np.asarray(Image.open(buffer)).astype(int)
    assert np.abs(as_jpeg(noisy, 40) - expected).mean() < 3


def test_most_pictures_change_a_little_and_some_not_at_all():
    rng = np.random.default_rng(0)
    image = np.kron(rng.integers(0, 256, (6, 8, 3)), np.ones((8, 8, 1))).astype(np.uint8)
    found = [degraded(image, rng) for _ in range(60)]
    changes = [np.abs(picture.astype(int) - image).mean() for picture in found]
    assert {picture.shape for picture in found} == {image.shape}
    assert 10 < sum(change == 0 for change in changes) < 50
    assert max(changes) < 30
