"""The ranking of hidden free ground against footprints, against scikit-free references."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footprints_edge_bench.accuracy.metrics import BINS, RankingCounts, covered, ranking


def pairs_auc(free, footprint):
    """The share of pairs that are in order, counted one by one."""
    pairs = [(a > b) + 0.5 * (a == b) for a in free for b in footprint]
    return sum(pairs) / len(pairs)


@given(
    st.lists(st.integers(0, BINS - 1), min_size=1, max_size=20),
    st.lists(st.integers(0, BINS - 1), min_size=1, max_size=20),
)
def test_the_auc_is_the_share_of_pairs_in_order(free, footprint):
    values = np.array([*free, *footprint])
    probability = ((values + 0.5) / BINS).astype(np.float32)[None]
    is_free = (np.arange(len(values)) < len(free))[None]
    found = ranking(probability, is_free, ~is_free)
    assert found.auc == pytest.approx(pairs_auc(free, footprint))


def test_images_add_up_to_the_auc_of_all_their_pixels():
    rng = np.random.default_rng(0)
    images = [
        (rng.random((9, 11), np.float32), rng.random((9, 11)) < 0.3, rng.random((9, 11)) < 0.1)
        for _ in range(3)
    ]
    one_by_one = [ranking(*image) for image in images]
    together = ranking(*(np.concatenate(parts) for parts in zip(*images, strict=True)))
    assert (one_by_one[0] + one_by_one[1] + one_by_one[2]) == together


def test_certain_probabilities_count_and_nothing_is_nan():
    ends = np.array([[0.0, 1.0]], np.float32)
    assert ranking(ends, ends > 0.5, ends < 0.5).auc == 1.0
    assert ranking(ends, ends < 0.5, ends > 0.5).auc == 0.0
    assert math.isnan(RankingCounts().auc)


def test_the_share_of_a_region_that_is_covered():
    region = np.array([[True, True, True, False]])
    assert covered(np.array([[True, False, False, True]]), region).recall == pytest.approx(1 / 3)
