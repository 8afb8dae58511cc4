"""What rounding the weights adds to a convolution's mean output, taken off its bias again.

Rounded weights W' differ from W, and after a ReLU the inputs have a mean, so the outputs are off by
(W' - W) E[x] on average: maps of an int8 network are a little too near, or too sure, everywhere.
Nagel et al., "Data-Free Quantization Through Weight Equalization and Bias Correction" (ICCV 2019);
here E[x] comes from the calibration photos.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import onnx
import onnxruntime as ort
from numpy.typing import NDArray
from onnx import numpy_helper

Floats = NDArray[np.float32]


def mean_inputs(
    model: onnx.ModelProto, inputs: Iterable[Mapping[str, Floats]]
) -> dict[str, Floats]:
    """E[x] of every convolution's input: channel means by the tensor's name, float32 (C,).

    Args:
        model: float32.
        inputs: what to run it on, one batch of one each.
    """
    given = {value.name for value in model.graph.input}
    wanted = sorted({node.input[0] for node in model.graph.node if node.op_type == "Conv"})
    watched = onnx.ModelProto()
    watched.CopyFrom(model)
    del watched.graph.output[:]
    watched.graph.output.extend(
        onnx.helper.make_empty_tensor_value_info(name) for name in wanted if name not in given
    )
    session = ort.InferenceSession(watched.SerializeToString(), providers=["CPUExecutionProvider"])
    names = [output.name for output in session.get_outputs()]
    sums = {name: np.zeros(1) for name in wanted}
    count = 0
    for feed in inputs:
        found = dict(zip(names, session.run(names, dict(feed)), strict=True)) | dict(feed)
        for name in wanted:
            sums[name] = sums[name] + found[name].mean(axis=(0, 2, 3))
        count += 1
    return {name: np.asarray(total / count, np.float32) for name, total in sums.items()}


def correct_biases(
    quantized: onnx.ModelProto, source: onnx.ModelProto, means: Mapping[str, Floats]
) -> None:
    """Takes (W' - W) E[x] off the int32 biases of a QDQ graph, in place.

    Args:
        quantized: from ``quantize_static``; its convolutions keep their names.
        source: the float32 graph it was made of.
        means: from :func:`mean_inputs`.
    """
    floats = {each.name: each for each in source.graph.initializer}
    integers = {each.name: each for each in quantized.graph.initializer}
    original = {node.name: node for node in source.graph.node if node.op_type == "Conv"}
    dequantize = {
        node.output[0]: node
        for node in quantized.graph.node
        if node.op_type == "DequantizeLinear" and node.input[0] in integers
    }
    for node in quantized.graph.node:
        if node.op_type != "Conv" or len(node.input) < 3 or node.name not in original:
            continue
        if node.input[1] not in dequantize or node.input[2] not in dequantize:
            continue
        weights = numpy_helper.to_array(floats[original[node.name].input[1]])
        rounded = _dequantized(integers, dequantize[node.input[1]].input)
        groups = next((a.i for a in node.attribute if a.name == "group"), 1)
        added = _added(
            (rounded - weights).sum(axis=(2, 3)), means[original[node.name].input[0]], groups
        )
        name, scale = dequantize[node.input[2]].input[:2]
        bias = numpy_helper.to_array(integers[name])
        steps = np.rint(added / numpy_helper.to_array(integers[scale]))
        integers[name].CopyFrom(numpy_helper.from_array((bias - steps).astype(np.int32), name))


def _dequantized(integers: Mapping[str, onnx.TensorProto], inputs: Sequence[str]) -> Floats:
    """Symmetric weights (O, I, h, w), one scale for each output or for all."""
    values, scale = (numpy_helper.to_array(integers[name]) for name in inputs[:2])
    return np.asarray(values * scale.reshape(-1, 1, 1, 1), np.float32)


def _added(error: Floats, mean: Floats, groups: int) -> Floats:
    """Mean shift of each output (O,); ``error`` is (O, I / groups), ``mean`` (I,)."""
    of_group = mean.reshape(groups, -1).repeat(len(error) // groups, axis=0)
    return np.asarray((error * of_group).sum(axis=1), np.float32)
