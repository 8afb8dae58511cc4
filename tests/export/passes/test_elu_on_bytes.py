"""ELU of codes gives the code that ELU of floats gave, or its neighbour."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footprints_edge_export.passes.elu_on_bytes import elu_on_bytes


def elu_graph(make_model, dtype, before, after, alpha=1.0):
    """Every code, through DequantizeLinear, Elu, QuantizeLinear of given ranges (low, high)."""
    lowest = np.iinfo(dtype).min
    constants = {}
    for name, (low, high) in {"in": before, "out": after}.items():
        scale = np.float32((high - low) / 255)
        constants[f"{name}_scale"] = scale
        constants[f"{name}_zero"] = dtype(
            np.clip(round(-low / scale) + lowest, lowest, lowest + 255)
        )
    codes = np.arange(lowest, lowest + 256).astype(dtype).reshape(1, 1, 16, 16)
    nodes = [
        ("DequantizeLinear", ["x", "in_scale", "in_zero"], "floats", {}),
        ("Elu", ["floats"], "bent", {"alpha": alpha}),
        ("QuantizeLinear", ["bent", "out_scale", "out_zero"], "codes", {}),
    ]
    return make_model(nodes, constants, codes, {"codes": dtype}), codes


def kinds(model):
    return {node.op_type for node in model.graph.node}


@given(
    dtype=st.sampled_from([np.uint8, np.int8]),
    low=st.floats(-12, -0.1),
    high=st.floats(0.1, 20),
)
def test_every_code_of_every_range(make_model, run, dtype, low, high, rewritten):
    model, codes = elu_graph(make_model, dtype, (low, high), (np.expm1(low), high))
    faster = rewritten(elu_on_bytes, model)
    for optimised in (False, True):
        (expected,) = run(model, codes, optimised=optimised)
        (found,) = run(faster, codes, optimised=optimised)
        assert np.abs(found.astype(int) - expected).max() <= 1
    if high >= 3.2 and low <= -1:
        assert "Elu" not in kinds(faster)


@pytest.mark.parametrize("high", [4, 8, 16])
def test_most_codes_are_the_same_and_none_leans(make_model, run, high, rewritten):
    model, codes = elu_graph(make_model, np.uint8, (-6, high), (-1, high))
    (expected,), (found,) = run(model, codes), run(rewritten(elu_on_bytes, model), codes)
    off = found.astype(int) - expected
    assert (off != 0).mean() < 0.1
    assert abs(off.mean()) < 0.1


def test_onnxruntime_computes_it_on_codes(make_model, optimised_nodes, tmp_path, rewritten):
    model, _ = elu_graph(make_model, np.uint8, (-6, 8), (-1, 8))
    (tmp_path / "elu.onnx").write_bytes(rewritten(elu_on_bytes, model).SerializeToString())
    found = {node.op_type for node in optimised_nodes(tmp_path / "elu.onnx")}
    assert found == {"QLinearSigmoid", "Clip", "QLinearAdd"}


@pytest.mark.parametrize(
    ("before", "alpha"), [((-6, 1), 1.0), ((-6, 8), 0.5)], ids=["too few positive codes", "alpha"]
)
def test_what_cannot_be_said_within_a_step_stays(make_model, before, alpha, rewritten):
    model, _ = elu_graph(make_model, np.uint8, before, (-1, before[1]), alpha)
    assert kinds(rewritten(elu_on_bytes, model)) == {"DequantizeLinear", "Elu", "QuantizeLinear"}
