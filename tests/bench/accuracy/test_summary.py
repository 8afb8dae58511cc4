"""Summaries over images."""

import pytest

from footprints_edge_bench.accuracy.metrics import MaskCounts
from footprints_edge_bench.accuracy.scoring import MethodScores
from footprints_edge_bench.accuracy.summary import summarise


def test_means_leave_out_images_that_say_nothing():
    images = [
        {"a": MethodScores(MaskCounts(1, 1, 2)), "b": MethodScores()},
        {"a": MethodScores(MaskCounts(0, 5, 0))},
        {"a": MethodScores(MaskCounts(4, 4, 4))},
    ]
    summary = summarise(images)["a"]["freespace"]
    assert summary.images == 2
    assert summary.means["iou"] == pytest.approx((0.5 + 1) / 2)
    assert summary.pooled["iou"] == pytest.approx(5 / (10 + 6 - 5))
    assert "b" in summarise(images) and not summarise(images)["b"]
