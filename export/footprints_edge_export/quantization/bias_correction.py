"""Bias correction: subtract from a bias what rounding the weights adds to the mean output.

Rounded weights W' differ from W, and after a ReLU the inputs have a mean, so the outputs are off by
(W' - W) E[x] on average: maps of an int8 network are a little too near, or too sure, everywhere.
Nagel et al., "Data-Free Quantization Through Weight Equalization and Bias Correction" (ICCV 2019);
here E[x] comes from the calibration photos.
"""

from collections.abc import Iterable, Mapping

import numpy as np
import onnx
import onnx_ir as ir
import onnxruntime as ort

from footprints_edge.foundation.types import Floats
from footprints_edge_export.graph.editing import (
    constant_input,
    needed,
    numbers,
    producer_of_input,
    set_constant,
    to_proto,
)


def mean_inputs(model: ir.Model, inputs: Iterable[Mapping[str, Floats]]) -> dict[str, Floats]:
    """E[x] of every convolution's input: channel means by the tensor's name, float32 (C,).

    Args:
        model: float32.
        inputs: what to run it on, one batch of one each.
    """
    given = {value.name for value in model.graph.inputs}
    convolutions = [node for node in model.graph if node.op_type == "Conv"]
    wanted = sorted({str(value.name) for conv in convolutions if (value := conv.inputs[0])})
    watched = to_proto(model)
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


def correct_biases(quantized: ir.Model, source: ir.Model, means: Mapping[str, Floats]) -> None:
    """Subtract (W' - W) E[x] from the int32 biases of a QDQ graph, in place.

    Args:
        quantized: from ``quantize_static``; its convolutions keep their names.
        source: the float32 graph it was made of.
        means: from :func:`mean_inputs`.
    """
    originals = {node.name: node for node in source.graph if node.op_type == "Conv"}
    for conv in quantized.graph:
        original = originals.get(conv.name) if conv.op_type == "Conv" else None
        if original is None:
            continue
        weight, bias = (_dequantize_of_constant(conv, index) for index in (1, 2))
        if weight is None or bias is None:
            continue
        error = (_dequantized(weight) - numbers(original.inputs[1])).sum(axis=(2, 3))
        mean = means[str(needed(original.inputs[0]).name)]
        added = _added(error, mean, conv.attributes.get_int("group", 1))
        steps = np.rint(added / numbers(bias.inputs[1]))
        set_constant(bias.inputs[0], (numbers(bias.inputs[0]) - steps).astype(np.int32))


def _dequantize_of_constant(conv: ir.Node, index: int) -> ir.Node | None:
    """The DequantizeLinear that makes a convolution's input from a constant, if one does."""
    node = producer_of_input(conv, index)
    if node is None or node.op_type != "DequantizeLinear" or constant_input(node, 0) is None:
        return None
    return node


def _dequantized(weight: ir.Node) -> Floats:
    """Symmetric weights (O, I, h, w), one scale for each output or for all."""
    values, scale = (numbers(value) for value in weight.inputs[:2])
    return np.asarray(values * scale.reshape(-1, 1, 1, 1), np.float32)


def _added(error: Floats, mean: Floats, groups: int) -> Floats:
    """Mean shift of each output (O,); ``error`` is (O, I / groups), ``mean`` (I,)."""
    of_group = mean.reshape(groups, -1).repeat(len(error) // groups, axis=0)
    return np.asarray((error * of_group).sum(axis=1), np.float32)
