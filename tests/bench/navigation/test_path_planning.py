"""Path planning: start and goal points, and scores of paths."""

from pathlib import Path

import numpy as np
import pytest

from footprints_edge_bench.ground_truth.base import GroundTruth, LabelledMask
from footprints_edge_bench.navigation.path_planning import random_ends, score_route

SIZE = (20, 30)


def ground_truth_of(ground, visible, valid=None):
    everywhere = np.ones(SIZE, bool)
    return GroundTruth(
        Path("none.jpg"),
        SIZE,
        visible_ground=LabelledMask(visible, everywhere),
        ground=LabelledMask(ground, everywhere if valid is None else valid),
    )


@pytest.fixture
def corridor():
    """Ground in rows 5 to 14; a thing hides its columns from 20 on; rows 0 and 1 are not known."""
    ground = np.zeros(SIZE, bool)
    ground[5:15] = True
    visible = ground.copy()
    visible[:, 20:] = False
    valid = np.ones(SIZE, bool)
    valid[:2] = False
    return ground_truth_of(ground, visible, valid)


def test_paths_go_from_visible_to_hidden_ground(corridor):
    ends = list(random_ends(corridor, 200, np.random.default_rng(0)))
    assert len(ends) == 200
    for (row, column), (to_row, to_column) in ends:
        assert 5 <= row < 15 and column < 20
        assert 5 <= to_row < 15 and to_column >= 20
    assert len(set(ends)) > 150
    assert ends == list(random_ends(corridor, 200, np.random.default_rng(0)))
    assert ends != list(random_ends(corridor, 200, np.random.default_rng(1)))


def test_without_hidden_ground_there_is_no_path(corridor):
    seen = ground_truth_of(corridor.ground.mask, corridor.ground.mask)
    assert list(random_ends(seen, 5, np.random.default_rng(0))) == []
    unknown = GroundTruth(Path("none.jpg"), SIZE, ground=corridor.ground)
    assert list(random_ends(unknown, 5, np.random.default_rng(0))) == []


def test_a_path_fails_where_it_leaves_known_ground(corridor):
    column = np.full(10, 4)
    inside = score_route(np.stack([np.arange(5, 15), column], 1), corridor, "a", "b")
    assert (inside.failed, inside.collisions) == (False, 0)
    leaving = score_route(np.stack([np.arange(8, 18), column], 1), corridor, "a", "b")
    assert (leaving.failed, leaving.collisions) == (True, pytest.approx(0.3))
    above = score_route(np.stack([np.arange(10), column], 1), corridor, "a", "b")
    assert above.collisions == pytest.approx(0.3)  # rows 2 to 4; rows 0 and 1 are not known
