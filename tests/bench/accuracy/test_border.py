"""The share of pixels near a true border that are right."""

import math

import numpy as np
import pytest

from footprints_edge_bench.accuracy.metrics import BORDER_PX, border

SIZE = (20, 40)
COLUMN = np.broadcast_to(np.arange(SIZE[1]), SIZE)
EVERYWHERE = np.ones(SIZE, bool)


@pytest.mark.parametrize("shift", range(BORDER_PX + 1))
def test_a_shifted_border_is_wrong_by_its_shift(shift):
    true, predicted = COLUMN < 20, COLUMN - shift < 20
    right = 1 - shift / (2 * BORDER_PX)
    assert border(predicted, true, EVERYWHERE).recall == pytest.approx(right)


def test_what_is_wrong_elsewhere_does_not_count():
    predicted = (COLUMN < 20) ^ (COLUMN < 5)
    assert border(predicted, COLUMN < 20, EVERYWHERE).recall == 1


def test_there_is_no_border_where_the_ground_truth_ends():
    true, valid = COLUMN < 20, COLUMN < 20
    assert math.isnan(border(EVERYWHERE, true, valid).recall)


@pytest.mark.parametrize("true", [EVERYWHERE, ~EVERYWHERE])
def test_a_picture_of_one_kind_has_no_border(true):
    assert math.isnan(border(EVERYWHERE, true, EVERYWHERE).recall)
