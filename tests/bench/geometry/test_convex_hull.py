"""Convex hulls of known shapes."""

import numpy as np

from footprints_edge_bench.geometry.convex_hull import convex_hull


def test_hulls_of_known_shapes():
    ell = np.zeros((30, 30), bool)
    ell[5:25, 5:10] = ell[20:25, 5:25] = True
    hull = convex_hull(ell)
    rows, columns = np.mgrid[:30, :30]
    # Its slanted side leads from the corner of pixel (5, 9) to that of (20, 24): r - c = const.
    expected = (rows >= 5) & (rows < 25) & (columns >= 5) & (columns < 25) & (columns - rows <= 4)
    np.testing.assert_array_equal(hull, expected)
    np.testing.assert_array_equal(convex_hull(hull), hull)
    assert not convex_hull(np.zeros((4, 5), bool)).any()
    one = np.zeros((4, 5), bool)
    one[2, 3] = True
    np.testing.assert_array_equal(convex_hull(one), one)
