"""Fresh processes."""

import pytest

from footprints_edge_bench.latency.cold_start import ColdStartError, cold_start


def test_a_cold_start_is_of_fresh_processes(green_is_ground):
    found = cold_start({"green": str(green_is_ground)}, 1, 2)
    assert found.base.n == found.infer.n == 2
    assert found.infer_against_base.value > 1
    assert set(found.steps_ms["green"]) == {"import", "load", "first frame"}
    # Python with numpy and onnxruntime takes tens of MB, a photo of 1.2 million pixels not a GB;
    # this process, with torch in it, takes more.
    assert 30e6 < found.steps_peak_bytes["green"] < 400e6
    assert 30e6 < found.infer_peak_bytes < 1e9
    assert "peak memory" in found.as_markdown()


def test_a_cold_start_that_fails_says_why(tmp_path):
    with pytest.raises(ColdStartError, match=r"none\.onnx"):
        cold_start({"none": str(tmp_path / "none.onnx")}, 1, 1)
