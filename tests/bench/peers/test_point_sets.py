"""Sampling and grouping, against the definitions spelled out point by point."""

import numpy as np
import pytest

from footprints_edge_bench.peers.point_sets import ball_query, farthest_points, three_nearest


@pytest.fixture
def points():
    return np.random.default_rng(3).uniform(-1, 1, (300, 3)).astype(np.float32)


def test_each_point_is_the_farthest_from_those_before_it(points):
    chosen = farthest_points(points, 20)
    assert chosen[0] == 0
    for place in range(1, 20):
        to_chosen = np.linalg.norm(points[:, None] - points[chosen[:place]], axis=2).min(1)
        assert to_chosen[chosen[place]] == pytest.approx(to_chosen.max())


def test_the_first_points_within_the_radius_of_each_centre_are_taken_in_order(points):
    centres = points[::7]
    found = ball_query(points, centres, 0.4, 6)
    for centre, indices in zip(centres, found, strict=True):
        near = np.flatnonzero(np.linalg.norm(points - centre, axis=1) <= 0.4)[:6]
        assert indices.tolist() == [*near, *[near[0]] * (6 - len(near))]
    assert any(len(set(row)) < 6 for row in found.tolist())  # both cases came up
    assert any(len(set(row)) == 6 for row in found.tolist())


def test_a_feature_is_interpolated_from_the_three_nearest(points):
    targets = points[:50] + np.float32(0.01)
    nearest, weights = three_nearest(points[50:], targets)
    distance = np.linalg.norm(targets[:, None] - points[50:], axis=2)
    assert (np.sort(nearest, 1) == np.sort(distance.argsort(1)[:, :3], 1)).all()
    by_hand = 1 / np.take_along_axis(distance, nearest, 1) ** 2
    assert weights == pytest.approx(by_hand / by_hand.sum(1, keepdims=True), abs=1e-3)
