"""ELU as three operators that onnxruntime computes on codes.

What it does: ``elu(x) = max(x, 0) + (min(exp(x), 1) - 1)``. The first term is a Clip of the codes.
The second is a sigmoid, ``exp(x) = sigmoid(x - k) / sigmoid(-k) * (1 + small)``: reading the codes
with a zero point moved by ``k / scale`` subtracts k, and a scale of ``sigmoid(-k) / 255`` lets
the codes saturate where the exponential reaches one. All of it is standard QuantizeLinear and
DequantizeLinear around Sigmoid and Add.

Why it is faster: onnxruntime has no ELU on codes; it dequantizes, computes in float and quantizes.
A sigmoid of codes is a table of 256 entries, the Clip and the sum are vectorised.

Bound: within one code of what DequantizeLinear, Elu, QuantizeLinear give. The exponential is off by
at most ``exp(-k) / 4 + 1 / 510``; where the positive codes do not reach far enough for that to be
less than a step of the result, the float ELU stays.
"""

import math

import numpy as np
import onnx
from onnx import helper

from footprints_edge_export.passes.rewriting import (
    Links,
    Quantization,
    add_constant,
    attribute,
    copied,
    links,
    tidied,
)

_LARGEST_K = 6.0
"""More makes the exponential no better, and sigmoid(-k) small against its table's rounding."""


def elu_on_bytes(model: onnx.ModelProto) -> onnx.ModelProto:
    """Rewrite a QDQ graph; see the module.

    Args:
        model: any graph; what does not fit the pattern stays.

    Returns:
        A new model; ``model`` is unchanged.
    """
    model = copied(model)
    linked = links(model.graph)
    for elu in [node for node in model.graph.node if node.op_type == "Elu"]:
        dequantize = linked.makers.get(elu.input[0])
        if dequantize is None or dequantize.op_type != "DequantizeLinear":
            continue
        before = linked.quantization(dequantize)
        if before is None or attribute(elu, "alpha", 1.0) != 1.0:
            continue
        for quantize in linked.readers.get(elu.output[0], []):
            if quantize.op_type == "QuantizeLinear":
                _replace(model.graph, linked, (dequantize, before), quantize)
    return tidied(model)


def _shift(before: Quantization, after: Quantization) -> int | None:
    """How far to move the zero point, in codes; None where the bound cannot be kept."""
    room = before.highest - before.zero_point
    shift = min(room, round(_LARGEST_K / before.scale))
    error = math.exp(-shift * before.scale) / 4 + 1 / 510
    return shift if error < after.scale else None


def _replace(
    graph: onnx.GraphProto,
    linked: Links,
    source: tuple[onnx.NodeProto, Quantization],
    quantize: onnx.NodeProto,
) -> None:
    """Compute what ``quantize`` gave from the codes that ``source`` dequantizes, in place."""
    dequantize, before = source
    after = linked.quantization(quantize)
    if after is None or before.dtype != after.dtype:
        return
    shift = _shift(before, after)
    if shift is None:
        return
    code = before.dtype.type
    name, codes = quantize.output[0], dequantize.input[0]
    sigmoid_at_zero = 1 / (1 + math.exp(shift * before.scale))

    def constant(what: str, value: float | int, kind: type[np.generic]) -> str:
        return add_constant(graph, f"{name}/{what}", np.array(value, kind))

    def node(operator: str, inputs: list[str], what: str) -> str:
        output = f"{name}/{what}"
        graph.node.append(helper.make_node(operator, inputs, [output], name=output))
        return output

    scale, zero_point = dequantize.input[1:3]
    moved = constant("moved_zero_point", before.zero_point + shift, code)
    shifted = node("DequantizeLinear", [codes, scale, moved], "shifted")
    sigmoid = node("Sigmoid", [shifted], "sigmoid")
    saturating = [
        constant("sigmoid_scale", sigmoid_at_zero / 255, np.float32),
        constant("lowest", before.lowest, code),
    ]
    exponential = node("QuantizeLinear", [sigmoid, *saturating], "exponential")
    less_one = [
        constant("exponential_scale", 1 / 255, np.float32),
        constant("highest", before.highest, code),
    ]
    negative = node("DequantizeLinear", [exponential, *less_one], "negative")
    clipped = node("Clip", [codes, zero_point], "clipped")
    positive = node("DequantizeLinear", [clipped, scale, zero_point], "positive")
    quantize.input[0] = node("Add", [positive, negative], "sum")
