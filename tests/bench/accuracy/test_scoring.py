"""Scores of one image."""

import json

from footprints_edge_bench.accuracy.metrics import DepthScores, MaskCounts
from footprints_edge_bench.accuracy.scoring import MethodScores


def test_scores_come_back_from_json():
    scores = MethodScores(
        MaskCounts(1, 2, 3), None, MaskCounts(0, 0, 0), DepthScores(0.1, 0.2, 1 / 3, 0.4)
    )
    assert MethodScores.from_json(json.loads(json.dumps(scores.as_json()))) == scores
