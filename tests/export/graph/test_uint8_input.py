"""The uint8 front of a graph says what the float front said, on every byte."""

import numpy as np
import onnx
import onnx_ir as ir
import onnxruntime as ort
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from onnx import TensorProto, helper, numpy_helper

from footprints_edge_export.errors import ExportError
from footprints_edge_export.graph.editing import constant, to_proto
from footprints_edge_export.graph.uint8_input import (
    NORMALISED,
    Normalisation,
    correct_first_bias,
    join_uint8_image,
    split_normalisation,
)

ARITHMETIC = {"Mul": np.multiply, "Div": np.divide, "Add": np.add, "Sub": np.subtract}
SHAPES = [(), (1,), (1, 1, 1, 1)]
WEIGHTS = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.25, 0.5, 0.25]], np.float32)[
    ..., None, None
]
BYTES = np.stack([np.arange(256), np.arange(256)[::-1], np.roll(np.arange(256), 99)], -1)
BYTES = BYTES.astype(np.uint8).reshape(1, 16, 16, 3)


def network(chain, *, bias=None, weights=WEIGHTS):
    """A float graph: scalar arithmetic on `image`, then one convolution."""
    nodes, constants, current = [], [numpy_helper.from_array(weights, "weights")], "image"
    for index, (operator, value) in enumerate(chain):
        constants.append(numpy_helper.from_array(np.asarray(value, np.float32), f"c{index}"))
        nodes.append(helper.make_node(operator, [current, f"c{index}"], [f"x{index}"], f"n{index}"))
        current = f"x{index}"
    inputs = [current, "weights"]
    if bias is not None:
        constants.append(numpy_helper.from_array(np.asarray(bias, np.float32), "bias"))
        inputs.append("bias")
    nodes.append(helper.make_node("Conv", inputs, ["maps"], "conv"))
    graph = helper.make_graph(
        nodes,
        "network",
        [helper.make_tensor_value_info("image", TensorProto.FLOAT, [1, 3, "H", "W"])],
        [helper.make_tensor_value_info("maps", TensorProto.FLOAT, [1, 4, "H", "W"])],
        constants,
    )
    opsets = [helper.make_opsetid("", 18)]
    return ir.from_proto(helper.make_model(graph, opset_imports=opsets, ir_version=10))


def run(model, feed):
    model = to_proto(model)
    onnx.checker.check_model(model, full_check=True)
    options = ort.SessionOptions()
    options.log_severity_level = 4
    options.intra_op_num_threads = 1
    session = ort.InferenceSession(model.SerializeToString(), options)
    (node,) = session.get_inputs()
    return session.run(None, {node.name: feed})[0]


def assert_bytes_give_what_floats_gave(chain):
    floats = (BYTES.astype(np.float32) / 255).transpose(0, 3, 1, 2)
    expected = run(network(chain), floats)

    model = network(chain)
    join_uint8_image(model, split_normalisation(model))
    (given_input,) = model.graph.inputs
    assert (given_input.name, given_input.dtype) == ("image", ir.DataType.UINT8)
    found = run(model, BYTES)

    # Largest number that the chain meets on its way, in float64: what rounding is relative to.
    slope, largest, x = 1.0, 1.0, np.array([0.0, 1.0])
    for operator, value in chain:
        x = ARITHMETIC[operator](x, float(np.asarray(value).reshape(())))
        slope = x[1] - x[0]
        largest = max(largest * (abs(slope) if operator in {"Mul", "Div"} else 1), abs(x).max())
    allowed = 2e-5 * abs(slope) + 2e-6 * largest
    assert np.abs(found - expected).max() <= allowed


factors = st.floats(0.05, 20).flatmap(lambda v: st.sampled_from([v, -v]))
steps = st.one_of(
    st.tuples(st.sampled_from(["Mul", "Div"]), factors),
    st.tuples(st.sampled_from(["Add", "Sub"]), st.floats(-3, 3)),
)
shaped = st.tuples(steps, st.sampled_from(SHAPES)).map(
    lambda drawn: (drawn[0][0], np.full(drawn[1], drawn[0][1], np.float32))
)


@settings(max_examples=150)
@given(st.lists(shaped, max_size=5))
def test_every_mix_of_scalar_arithmetic(chain):
    assert_bytes_give_what_floats_gave(chain)


@pytest.mark.parametrize(
    "chain",
    [
        [],
        [("Sub", 0.45), ("Div", 0.225)],
        [("Mul", 255), ("Sub", 127), ("Div", 128)],
        [("Mul", 2), ("Sub", 1)],
        [("Sub", 1), ("Mul", 3)],
        [("Add", 1), ("Div", 2)],
        [("Sub", 2)],
        [("Mul", -1), ("Add", 1)],
    ],
    ids=["none", "reference", "edge", "-1 to 1", "-3 to 0", "0.5 to 1", "-2 to -1", "negative"],
)
def test_usual_normalisations(chain):
    assert_bytes_give_what_floats_gave(chain)


def test_the_two_networks_own_normalisations_as_bytes():
    edge = split_normalisation(network([("Mul", 255), ("Sub", 127), ("Div", 128)]))
    assert edge.scale == pytest.approx(1 / 128)
    assert edge.zero_byte == pytest.approx(127)
    assert edge.is_whole
    reference = split_normalisation(network([("Sub", 0.45), ("Div", 0.225)]))
    assert reference.scale == pytest.approx(1 / 255 / 0.225)
    assert reference.zero_byte == pytest.approx(0.45 * 255)
    assert not reference.is_whole


def test_the_cut_off_arithmetic_is_gone():
    model = network([("Sub", 0.5), ("Div", 0.25)])
    split_normalisation(model)
    assert [node.op_type for node in model.graph] == ["Conv"]
    assert list(model.graph.initializers) == ["weights"]
    assert [value.name for value in model.graph.inputs] == [NORMALISED]


def test_a_fixed_size_stays_fixed_and_a_free_one_free():
    for sides in (("H", "W"), (16, 16)):
        model = network([("Sub", 0.5)])
        model.graph.inputs[0].shape = ir.Shape([1, 3, *sides])
        join_uint8_image(model, split_normalisation(model))
        for value, shape in (
            (model.graph.inputs[0], (1, *sides, 3)),
            (model.graph.outputs[0], (1, 4, *sides)),
        ):
            assert value.shape == shape


def test_a_normalisation_by_channel_is_refused():
    model = network([("Sub", np.array([0.485, 0.456, 0.406]).reshape(1, 3, 1, 1)), ("Div", 0.225)])
    with pytest.raises(ExportError, match="Sub"):
        split_normalisation(model)


def test_a_constant_minus_the_picture_is_refused():
    model = network([("Sub", 0.5)])
    first = model.graph[0]
    image, half = first.inputs
    first.replace_input_with(0, half)
    first.replace_input_with(1, image)
    with pytest.raises(ExportError, match="Sub"):
        split_normalisation(model)


@settings(max_examples=40)
@given(zero_byte=st.floats(0.5, 254.5), scale=st.floats(0.001, 0.1), seed=st.integers(0, 99))
def test_the_first_bias_makes_up_for_a_rounded_zero(zero_byte, scale, seed):
    """conv(scale (x - zero)) == corrected conv(scale (x - whole zero)): no padding, exact."""
    rng = np.random.default_rng(seed)
    weights, bias = rng.normal(size=(4, 3, 3, 3)).astype(np.float32), rng.normal(size=4)
    normalisation = Normalisation(scale, zero_byte)
    model = network([("Sub", 0.5)], weights=weights, bias=bias)
    split_normalisation(model)
    pixels = BYTES.astype(np.float32).transpose(0, 3, 1, 2)
    expected = run(model, (scale * (pixels - zero_byte)).astype(np.float32))
    correct_first_bias(model, normalisation)
    whole = np.float32(round(zero_byte))
    found = run(model, (scale * (pixels - whole)).astype(np.float32))
    assert np.abs(found - expected).max() <= 0.003 * scale * np.abs(weights).sum() / 4 + 1e-4


def test_nothing_is_corrected_where_the_zero_is_whole():
    model = network([("Sub", 0.5)], bias=[1, 2, 3, 4])
    split_normalisation(model)
    correct_first_bias(model, Normalisation(1 / 128, 127))
    np.testing.assert_array_equal(constant(model.graph.initializers["bias"]), [1, 2, 3, 4])


def test_a_first_convolution_without_bias_gets_one():
    """The exporter drops a bias of zeros, such as an untrained batch norm folds into."""
    normalisation, found = Normalisation(0.01, 114.75), []
    pixels = BYTES.astype(np.float32).transpose(0, 3, 1, 2)
    for bias in (None, [0, 0, 0, 0]):
        model = network([("Sub", 0.5)], bias=bias)
        split_normalisation(model)
        correct_first_bias(model, normalisation)
        found.append(run(model, np.float32(0.01) * (pixels - 115)))
    np.testing.assert_array_equal(*found)
    expected = np.einsum("oi,nihw->nohw", WEIGHTS[..., 0, 0], 0.01 * (pixels - 114.75))
    np.testing.assert_allclose(found[0], expected, atol=1e-5)


def test_a_network_that_does_not_begin_with_a_convolution_is_refused():
    model = network([("Sub", 0.5)])
    split_normalisation(model)
    model.graph[0].op_type = "Gemm"
    with pytest.raises(ExportError, match="begins with a Conv, not Gemm"):
        correct_first_bias(model, Normalisation(0.01, 114.75))
