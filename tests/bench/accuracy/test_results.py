"""Scores on disk."""

import pytest

from footprints_edge_bench.accuracy.metrics import MaskCounts
from footprints_edge_bench.accuracy.results import Results, ResultsError
from footprints_edge_bench.accuracy.scoring import MethodScores


def test_a_damaged_file_of_results_is_refused(tmp_path):
    path = tmp_path / "results.jsonl"
    Results(path, {"a": 1}).add("x", {"row": MethodScores(MaskCounts(1, 2, 3))})
    assert Results(path, {"a": 1}).images == {"x": {"row": MethodScores(MaskCounts(1, 2, 3))}}
    path.write_text(path.read_text() + "nonsense\n")
    with pytest.raises(ResultsError, match="damaged"):
        Results(path, {"a": 1})
    path.write_text("nonsense\n")
    with pytest.raises(ResultsError, match="not from this program"):
        Results(path, {"a": 1})
    assert Results(path, {"a": 1}, fresh=True).images == {}
