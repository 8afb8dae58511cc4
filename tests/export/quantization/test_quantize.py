"""Quantization of a graph whose answers are known: what int8 adds on average is taken off again."""

import numpy as np
import onnx
import onnx_ir as ir
import onnxruntime as ort
import pytest
from onnx import TensorProto, helper, numpy_helper

from footprints_edge_export.graph.editing import to_proto
from footprints_edge_export.graph.uint8_input import NORMALISED, Normalisation
from footprints_edge_export.quantization.bias_correction import correct_biases, mean_inputs
from footprints_edge_export.quantization.quantize import quantize

NORMALISATION = Normalisation(scale=np.float32(1 / 128), zero_byte=127.0)


def convolution(name, source, target, weights, bias, group=1):
    initializers = [
        numpy_helper.from_array(weights, f"{name}.weight"),
        numpy_helper.from_array(bias, f"{name}.bias"),
    ]
    inputs = [source, f"{name}.weight", f"{name}.bias"]
    node = helper.make_node("Conv", inputs, [target], name, group=group)
    return node, initializers


@pytest.fixture
def network():
    """Convolution, ReLU, depthwise convolution, ReLU and a last convolution that stays float."""
    rng = np.random.default_rng(3)
    nodes, initializers = [], []
    source = NORMALISED
    for name, shape, group in (("first", (8, 3), 1), ("depthwise", (8, 1), 8), ("last", (4, 8), 1)):
        weights = rng.normal(0.2, 1, (*shape, 3, 3)).astype(np.float32)
        bias = rng.normal(0, 0.5, shape[0]).astype(np.float32)
        node, added = convolution(name, source, f"{name}.out", weights, bias, group)
        nodes.append(node)
        initializers += added
        source = f"{name}.out"
        if name != "last":
            nodes.append(helper.make_node("Relu", [source], [f"{name}.relu"], f"{name}_relu"))
            source = f"{name}.relu"
    graph = helper.make_graph(
        nodes,
        "network",
        [helper.make_tensor_value_info(NORMALISED, TensorProto.FLOAT, [1, 3, "h", "w"])],
        [helper.make_tensor_value_info("last.out", TensorProto.FLOAT, [1, 4, "a", "b"])],
        initializers,
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=8)


@pytest.fixture
def photos():
    rng = np.random.default_rng(4)
    return [rng.integers(90, 256, (1, 32, 48, 3), np.uint8) for _ in range(6)]


def feed(photo):
    x = (photo.astype(np.float32) - 127) / 128
    return {NORMALISED: np.ascontiguousarray(x.transpose(0, 3, 1, 2))}


def mean_outputs(model, photos, name="last.out"):
    """Channel means of a tensor over all photos."""
    watched = onnx.ModelProto()
    watched.CopyFrom(model)
    del watched.graph.output[:]
    watched.graph.output.append(helper.make_empty_tensor_value_info(name))
    options = ort.SessionOptions()  # without saturation on x86 processors that have no VNNI
    options.add_session_config_entry("session.x64quantprecision", "1")
    session = ort.InferenceSession(
        watched.SerializeToString(), options, providers=["CPUExecutionProvider"]
    )
    return np.mean([session.run(None, feed(photo))[0].mean(axis=(0, 2, 3)) for photo in photos], 0)


def test_mean_inputs_are_means_over_all_photos(network, photos):
    means = mean_inputs(ir.from_proto(network), (feed(photo) for photo in photos))
    assert set(means) == {NORMALISED, "first.relu", "depthwise.relu"}
    expected = np.mean([feed(photo)[NORMALISED].mean(axis=(0, 2, 3)) for photo in photos], 0)
    np.testing.assert_allclose(means[NORMALISED], expected, atol=1e-6)
    assert (means["first.relu"] > 0).all()


@pytest.mark.parametrize("name", ["first", "depthwise"])
def test_what_rounding_adds_on_average_is_taken_off(network, photos, rewritten, name):
    """Weights all rounded up to the next quarter: far coarser than int8, and to one side."""
    coarse = onnx.ModelProto()
    coarse.CopyFrom(network)
    initializers = {each.name: each for each in coarse.graph.initializer}
    node = next(node for node in coarse.graph.node if node.name == name)
    for index, part, step, kind in ((1, "weight", 0.25, np.int8), (2, "bias", 1e-6, np.int32)):
        values = numpy_helper.to_array(initializers[f"{name}.{part}"])
        rounded = np.ceil(values / step).astype(kind)
        initializers[f"{name}.{part}"].CopyFrom(numpy_helper.from_array(rounded, f"{name}.{part}"))
        scale = numpy_helper.from_array(np.float32(step), f"{name}.{part}.scale")
        coarse.graph.initializer.append(scale)
        node.input[index] = f"{name}.{part}.float"
        inputs = [f"{name}.{part}", scale.name]
        coarse.graph.node.insert(
            0, helper.make_node("DequantizeLinear", inputs, [node.input[index]])
        )
    wanted = mean_outputs(network, photos, f"{name}.out")
    before = np.abs(mean_outputs(coarse, photos, f"{name}.out") - wanted)
    source = ir.from_proto(network)
    means = mean_inputs(source, map(feed, photos))
    coarse = rewritten(correct_biases, coarse, source, means)
    after = np.abs(mean_outputs(coarse, photos, f"{name}.out") - wanted)
    assert before.max() > 0.2
    assert after.max() < 0.05 * before.max()


def test_int8_keeps_the_mean_of_every_output(network, photos):
    # 7-bit weights: with 8 bits, CPUs without VNNI saturate, and these sums are large
    int8 = to_proto(quantize(ir.from_proto(network), NORMALISATION, photos, "x86-avx2"))
    wanted = mean_outputs(network, photos)
    assert np.abs(mean_outputs(int8, photos) - wanted).max() < 0.01 * np.abs(wanted).max()
    quantized = [node.op_type for node in int8.graph.node].count("QuantizeLinear")
    assert quantized >= 3
