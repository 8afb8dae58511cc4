"""Multiply-additions describe_precisions against closed forms, and networks under their roof."""

import json

import numpy as np
import pytest

from footprints_edge_bench.engines.backend import Backend
from footprints_edge_bench.engines.ort_profile import Operator, convolutions, operators, profile
from footprints_edge_bench.latency.machine import machine
from footprints_edge_bench.latency.roofline import peak_gmac_s, roofline, under_roof
from footprints_edge_bench.model_files.model_cache import ModelCache


def event(name, kind, start_us, spent_us, inputs, output):
    shapes = {"input_type_shape": inputs, "output_type_shape": [{"float": output}]}
    arguments = {"node_index": name, "op_name": kind, **shapes}
    names = {"name": f"{name}_kernel_time", "cat": "Node"}
    return {**names, "ts": start_us, "dur": spent_us, "args": arguments}


def test_events_become_operators():
    image, scale = {"uint8": [1, 8, 10, 3]}, {"float": []}
    events = [
        {"cat": "OnnxRuntimeEngine", "name": "model_run", "ts": 0, "dur": 9999, "args": {}},
        *(
            event("c", "QLinearConv", start, spent, [image, scale], [1, 4, 5, 16])
            for start, spent in ((0, 9000), (10_000, 300), (20_000, 100), (30_000, 200))
        ),
        *(
            event("j", "QLinearConcat", start, 50, [scale, {"uint8": [1]}, image], [1, 8, 10, 6])
            for start in (1, 10_001, 20_001, 30_001)
        ),
    ]
    conv, concat = operators(events, 3, {"c": [16, 3, 3, 3]})
    # The first frame does not count; of the others the median. 3x3x3 for each of 4x5x16 outputs.
    assert conv == Operator("QLinearConv", 0.2, 4 * 5 * 16 * 27, "uint8")
    assert concat == Operator("QLinearConcat", 0.05, 0, "uint8")
    assert conv.is_integer
    assert not concat.is_integer
    assert convolutions([conv, concat]) == {"int8": 1}


def test_a_real_profile_counts_the_convolution(green_is_ground):
    image = np.zeros((1, 32, 64, 3), np.uint8)
    found = profile(green_is_ground, {"image": image}, threads=1, frames=2)
    (conv,) = [each for each in found if each.is_convolution]
    # 1x1, 3 channels to 4; a kernel that lays channels out in blocks may pad the 4.
    exact = 32 * 64 * 3 * 4
    assert conv.macs >= exact
    assert conv.macs % exact == 0
    assert conv.ms > 0
    assert convolutions(found) == {"float32": 1}


def test_the_roof_is_the_work_at_the_peak_of_its_precision():
    found = under_roof(
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
