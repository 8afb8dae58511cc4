"""The encoding of depth for SSCNet, against a wall in closed form."""

import numpy as np
import pytest

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_bench.peers.tsdf import flipped_tsdf

CAMERA = Intrinsics(100.0, 100.0, 99.5, 99.5)


def test_a_wall_is_1_and_falls_to_0_on_both_sides_with_opposite_signs():
    wall_m = np.full((200, 200), 1.01, np.float32)
    encoded = flipped_tsdf(wall_m, CAMERA, (20, 20, 40), 0.05, camera_height_m=0.5)
    on_axis = encoded[10, 10]  # the voxel of the wall is number 20
    away_m = 0.05 * np.abs(np.arange(40) - 20)
    expected = np.maximum(1 - away_m / 0.24, 0)
    assert np.abs(on_axis) == pytest.approx(expected, abs=1e-6)
    assert (on_axis[16:20] > 0).all()
    assert (on_axis[21:25] < 0).all()


def test_what_the_camera_does_not_see_counts_as_behind():
    wall_m = np.full((200, 200), 1.01, np.float32)
    encoded = flipped_tsdf(wall_m, CAMERA, (80, 20, 40), 0.05, camera_height_m=0.5)
    assert encoded[0, 10, 18] <= 0  # 2 m to the side, 0.9 m ahead: outside of the picture
