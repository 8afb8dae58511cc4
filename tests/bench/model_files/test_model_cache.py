"""Converted model files are kept."""

import pytest

from footprints_edge_bench.model_files.model_cache import ModelCache


def test_a_failed_making_leaves_nothing(tmp_path):
    def fail(folder):
        (folder / "half").write_text("half")
        raise RuntimeError("no")

    files = ModelCache(tmp_path)
    with pytest.raises(RuntimeError, match="no"):
        files.kept("thing", {"a": 1}, fail)
    assert list(tmp_path.iterdir()) == []
    made = files.kept("thing", {"a": 1}, lambda folder: (folder / "whole").write_text("1"))
    assert files.kept("thing", {"a": 1}, fail) == made
    other = files.kept("thing", {"a": 2}, lambda folder: (folder / "whole").write_text("2"))
    assert other != made
