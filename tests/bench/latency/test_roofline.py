"""Networks against the peak of the machine."""

import json

import pytest

from footprints_edge_bench.engines.backend import Backend
from footprints_edge_bench.engines.ort_profile import Operator
from footprints_edge_bench.latency.machine import machine
from footprints_edge_bench.latency.roofline import compare_with_peaks, peak_gmac_s, roofline
from footprints_edge_bench.model_files.model_cache import ModelCache


def test_the_roof_is_the_work_at_the_peak_of_its_precision():
    found = compare_with_peaks(
        "net",
        5.0,
        [
            Operator("QLinearConv", 2.0, 400_000_000, "uint8"),
            Operator("QLinearConv", 1.0, 200_000_000, "uint8"),
            Operator("Conv", 4.0, 100_000_000, "float"),
            Operator("Elu", 7.0, 0, "float"),
        ],
        {"int8": 600.0, "fp32": 100.0},
    )
    assert found.least_ms == pytest.approx(1 + 1)  # 0.6 G at 600 G/s and 0.1 G at 100 G/s
    assert found.profiled_ms == pytest.approx(14)
    rows = {kind.name: (kind.count, kind.ms, kind.of_peak) for kind in found.kinds}
    assert rows["QLinearConv uint8"] == (2, 3.0, pytest.approx(1 / 3))
    assert rows["Conv float"] == (1, 4.0, pytest.approx(1 / 4))
    assert rows["Elu float"] == (1, 7.0, None)
    assert [kind.name for kind in found.kinds][:2] == ["Elu float", "Conv float"]


def test_the_peak_is_a_rate():
    found = peak_gmac_s(side=64, threads=1, trials=1)
    assert set(found) == {"int8", "fp32"}
    assert all(0.01 < rate < 1e6 for rate in found.values())


def test_a_tiny_roofline_from_end_to_end(green_is_ground, tmp_path):
    row = Backend(str(green_is_ground), (32, 64), "onnxruntime", "fp32")
    found = roofline([row], ModelCache(tmp_path), machine(), threads=1, trials=2, side=64)
    (network,) = found.networks
    assert network.ms > 0
    assert network.least_ms > 0
    assert any(kind.of_peak for kind in network.kinds)
    text = found.as_markdown()
    assert row.name in text
    assert "Conv float" in text
    assert json.loads(found.as_json())["networks"][0]["ms"] == network.ms
