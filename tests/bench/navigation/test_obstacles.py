"""The nearest thing by bearing, from exact depth."""

import numpy as np
import pytest

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.geometry.ground_plane import GroundPlane
from footprints_edge_bench.navigation.obstacles import (
    ObstacleScore,
    as_markdown,
    nearest_things_m,
)

CAMERA = Intrinsics(300, 300, 223.5, 127.5)
PLANE = GroundPlane(np.array([0.0, -1.0, 0.0]), 1.0, 0.0)
"""A level camera 1 m above the floor."""


def wall(distance_m, bottom_m, top_m):
    """The depth of a floor and a wall across the view, between two heights above the floor."""
    down = (np.arange(256) - CAMERA.cy)[:, None] / CAMERA.fy + np.zeros((256, 448))
    floor_m = np.where(down > 0.01, 1 / np.maximum(down, 0.01), 0)
    above_m = 1 - distance_m * down
    there = (above_m >= bottom_m) & (above_m <= top_m)
    return np.where(there, distance_m, floor_m).astype(np.float32)


@pytest.mark.parametrize(
    ("bottom_m", "top_m", "expected_m"),
    [(0, 2, 3.0), (0, 0.1, np.inf), (1.3, 2, np.inf), (0.6, 0.8, 3.0)],
)
def test_the_nearest_thing_stands_between_a_step_and_the_robots_height(bottom_m, top_m, expected_m):
    bearings = np.array([0.0, 10.0])
    found = nearest_things_m(wall(3.0, bottom_m, top_m), CAMERA, PLANE, bearings)
    np.testing.assert_allclose(found, expected_m / np.cos(np.radians(bearings)), rtol=0.01)


def test_a_few_stray_pixels_are_no_thing():
    depth_m = wall(3.0, 0, 2)
    depth_m[120:122, 222:226] = 1.0
    found = nearest_things_m(depth_m, CAMERA, PLANE, np.array([0.0]))
    np.testing.assert_allclose(found, 3.0, rtol=0.01)


def test_shares_are_of_bearings_and_a_missing_plane_is_no_distance():
    scores = [
        ObstacleScore(np.array([1.0, 2.6, np.inf, 0.5]), np.array([1.0, 2.0, 3.0, 1.0]), True),
        ObstacleScore(np.array([np.inf]), np.array([1.0]), False),
    ]
    lines = as_markdown({"model": scores}).splitlines()
    assert "| model | 1.15 | 50.0% | 25.0% | 1 | 4 |" in lines
    assert lines[-3:] == ["| 0.50 | 0.00 |", "| 1.00 | 1.00 |", "| 2.60 | 0.00 |"]
