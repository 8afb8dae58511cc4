"""Synthetic photos."""

import numpy as np

from footprints_edge_bench.model_files.synthetic_photos import synthetic_jpeg, synthetic_photo


def test_photos_are_seeded_and_differ():
    np.testing.assert_array_equal(synthetic_photo((48, 64), 1), synthetic_photo((48, 64), 1))
    assert (
        np.abs(synthetic_photo((48, 64), 1).astype(int) - synthetic_photo((48, 64), 2)).mean() > 10
    )
    assert synthetic_jpeg((48, 64))[:2] == b"\xff\xd8"
