"""Quantized sums whose every byte is what exact arithmetic gives, on any processor."""

import numpy as np
import onnx
import onnxruntime as ort
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from onnx import TensorProto, helper, numpy_helper

from footprints_edge_export.quantization.exact_add_scales import make_sums_exact

SCALES = st.floats(2**-6, 4, width=32)
ZEROS = st.integers(0, 255)


def quantization(name, scale, zero):
    return [
        numpy_helper.from_array(np.float32(scale), f"{name}_scale"),
        numpy_helper.from_array(np.uint8(zero), f"{name}_zero"),
    ]


def node(kind, source, target, of):
    return helper.make_node(kind, [source, f"{of}_scale", f"{of}_zero"], [target], target)


def sums(addends, scales, zeros):
    """Codes x0, x1, ... to the codes of x0 + x1, of that + x2, and so on; sums are s1, s2, ..."""
    names = [*(f"x{i}" for i in range(addends)), *(f"s{i}" for i in range(1, addends))]
    nodes = [node("DequantizeLinear", f"x{i}", f"x{i}.float", f"x{i}") for i in range(addends)]
    before = "x0.float"
    for i in range(1, addends):
        nodes.append(helper.make_node("Add", [before, f"x{i}.float"], [f"s{i}.exact"]))
        nodes.append(node("QuantizeLinear", f"s{i}.exact", f"s{i}", f"s{i}"))
        nodes.append(node("DequantizeLinear", f"s{i}", f"s{i}.float", f"s{i}"))
        before = f"s{i}.float"
    graph = helper.make_graph(
        nodes,
        "sums",
        [
            helper.make_tensor_value_info(f"x{i}", TensorProto.UINT8, [1, 1, 256, 256])
            for i in range(addends)
        ],
        [helper.make_tensor_value_info(f"s{addends - 1}", TensorProto.UINT8, [1, 1, 256, 256])],
        [
            each
            for name, scale, zero in zip(names, scales, zeros, strict=True)
            for each in quantization(name, scale, zero)
        ],
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=8)


def constants(model):
    return {each.name: numpy_helper.to_array(each) for each in model.graph.initializer}


@settings(max_examples=30)
@given(scales=st.tuples(SCALES, SCALES, SCALES), zeros=st.tuples(ZEROS, ZEROS, ZEROS))
def test_every_pair_of_bytes_gives_what_exact_arithmetic_gives(rewritten, scales, zeros):
    model = sums(2, scales, zeros)
    model = rewritten(make_sums_exact, model)
    found = constants(model)
    a, b = np.mgrid[0:256, 0:256]
    # A double holds each product and the sum whole: this rounds once. Of halves onnxruntime takes
    # the even one with the zero point added, everywhere.
    ratios = [float(found[f"x{i}_scale"]) / float(found["s1_scale"]) for i in (0, 1)]
    exact = (a - zeros[0]) * ratios[0] + (b - zeros[1]) * ratios[1]
    expected = np.clip(np.rint(exact + zeros[2]), 0, 255)
    session = ort.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
    feed = {f"x{i}": each.astype(np.uint8)[None, None] for i, each in enumerate((a, b))}
    np.testing.assert_array_equal(session.run(None, feed)[0][0, 0], expected)


@given(scales=st.lists(SCALES, min_size=7, max_size=7))
def test_sums_of_sums_of_sums_have_short_ratios_too(rewritten, scales):
    model = sums(4, scales, [0] * 7)
    given_scales = constants(model)
    model = rewritten(make_sums_exact, model)
    found = constants(model)
    for i in range(1, 4):
        for addend in (f"x{i}", "x0" if i == 1 else f"s{i - 1}"):
            ratio = found[f"{addend}_scale"] / found[f"s{i}_scale"]
            mantissa, _ = np.frexp(ratio)
            assert (mantissa * 64).is_integer()
    for name, scale in found.items():
        if name.endswith("_scale"):
            assert 1 <= scale / given_scales[name] <= 33 / 32


@pytest.mark.parametrize("biased", [True, False])
def test_biases_stay_what_they_are(rewritten, biased):
    """In steps of the scale of what their convolution reads, which is another now."""
    model = sums(2, (0.011, 0.023, 0.0311), (3, 4, 5))
    rng = np.random.default_rng(0)
    values = {
        "weights": rng.integers(-127, 128, (2, 1, 3, 3)).astype(np.int8),
        "weights_scale": np.array([0.01, 0.02], np.float32),
        "weights_zero": np.zeros(2, np.int8),
        "bias": np.array([12345, -54321], np.int32),
        "bias_scale": np.array([0.01, 0.02], np.float32) * np.float32(0.0311),
        "bias_zero": np.zeros(2, np.int32),
    }
    for name in ("weights", "bias"):
        inputs = [name, f"{name}_scale", f"{name}_zero"]
        model.graph.node.append(
            helper.make_node("DequantizeLinear", inputs, [f"{name}.float"], axis=0)
        )
    inputs = ["s1.float", "weights.float", "bias.float"][: 2 + biased]
    model.graph.node.append(helper.make_node("Conv", inputs, ["y"]))
    model.graph.initializer.extend(numpy_helper.from_array(v, k) for k, v in values.items())
    onnx.checker.check_model(model)
    model = rewritten(make_sums_exact, model)
    found = constants(model)
    if not biased:
        np.testing.assert_array_equal(found["bias"], values["bias"])
        return
    np.testing.assert_allclose(
        found["bias_scale"], found["s1_scale"] * values["weights_scale"], rtol=1e-6
    )
    assert found["s1_scale"] > np.float32(0.0311)
    np.testing.assert_allclose(
        found["bias"] * found["bias_scale"], values["bias"] * values["bias_scale"], rtol=1e-4
    )


def test_floats_are_left_alone(rewritten):
    """A sum, and a convolution whose input and bias are computed."""
    shape = [1, 1, 4, 4]
    inputs = [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name in "ab"]
    inputs.append(helper.make_tensor_value_info("bias", TensorProto.FLOAT, [1]))
    output = helper.make_tensor_value_info("y", TensorProto.FLOAT, shape)
    nodes = [
        helper.make_node("Add", ["a", "b"], ["c"]),
        helper.make_node("Relu", ["c"], ["d"]),
        helper.make_node("Relu", ["bias"], ["e"]),
        helper.make_node("Conv", ["d", "weights", "e"], ["y"]),
    ]
    weights = numpy_helper.from_array(np.ones((1, 1, 1, 1), np.float32), "weights")
    model = helper.make_model(helper.make_graph(nodes, "g", inputs, [output], [weights]))
    onnx.checker.check_model(model)
    after = rewritten(make_sums_exact, model)
    assert after.graph.node == model.graph.node
    assert after.graph.initializer == model.graph.initializer
