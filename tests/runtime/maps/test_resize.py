import numpy as np
import pytest

from footprints_edge.maps.resize import resize_map, resize_rows


@pytest.mark.parametrize("size", [(200, 90), (37, 30), (13, 11)])
def test_rows_alone_are_those_of_the_whole(size):
    values = np.random.default_rng(0).random((37, 30), np.float32)
    whole = resize_map(values, size)
    for start, stop in [(0, 5), (3, 13), (5, 6), (0, size[0]), (size[0] - 2, size[0])]:
        rows = resize_rows(values, size, slice(start, stop))
        np.testing.assert_allclose(rows, whole[start:stop], atol=1e-6)
