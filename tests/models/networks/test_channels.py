"""Disparity and depth: the torch functions against the runtime's, and against the paper's range."""

import numpy as np
import pytest
import torch

from footprints_edge.geometry import camera as geometry
from footprints_edge_models.networks.channels import (
    depth_to_disparity,
    disparity_to_depth_m,
    raw_to_maps,
)


def test_depth_of_disparity_is_the_runtimes():
    disparity = np.linspace(0, 1, 1001)
    ours = disparity_to_depth_m(torch.from_numpy(disparity)).numpy()
    np.testing.assert_allclose(ours, geometry.disparity_to_depth(disparity), rtol=1e-12)


def test_disparity_of_depth_is_the_runtimes():
    depth_m = np.geomspace(0.1, 100, 1001)
    ours = depth_to_disparity(torch.from_numpy(depth_m)).numpy()
    np.testing.assert_allclose(ours, geometry.depth_to_disparity(depth_m), rtol=1e-9, atol=1e-12)


def test_the_two_undo_each_other():
    depth_m = torch.logspace(-1, 2, 500, dtype=torch.float64)
    torch.testing.assert_close(
        disparity_to_depth_m(depth_to_disparity(depth_m)), depth_m, rtol=1e-10, atol=0
    )


def test_the_paper_s_range_and_formula():
    depth_m = disparity_to_depth_m(torch.tensor([0.0, 0.5, 1.0], dtype=torch.float64))
    assert depth_m.tolist() == pytest.approx([100, 1 / (0.01 + 9.99 / 2), 0.1])


def test_maps_are_probabilities_and_the_disparities_as_they_are():
    raw = torch.tensor([0.0, float(np.log(3)), 0.25, 0.75]).reshape(1, 4, 1, 1).expand(1, 4, 2, 3)
    maps = raw_to_maps(raw)
    assert maps.shape == (1, 4, 2, 3)
    for channel, value in enumerate((0.5, 0.75, 0.25, 0.75)):
        torch.testing.assert_close(maps[:, channel], torch.full((1, 2, 3), value))
