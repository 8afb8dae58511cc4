import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footprints_edge_models.training.validation import rank_auc

values = st.lists(st.integers(-3, 3), min_size=1, max_size=15)


@given(values, values)
def test_the_auc_is_the_share_of_pairs_in_order(high, low):
    pairs = [(a > b) + 0.5 * (a == b) for a in high for b in low]
    found = rank_auc(np.array(high, np.float32), np.array(low, np.float32))
    assert found == pytest.approx(sum(pairs) / len(pairs))


def test_nothing_to_rank_is_nan():
    none = np.zeros(0, np.float32)
    assert math.isnan(rank_auc(none, np.ones(3, np.float32)))
    assert math.isnan(rank_auc(np.ones(3, np.float32), none))
