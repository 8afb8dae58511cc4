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
import onnx_ir as ir

from footprints_edge_export.graph.editing import (
    NewNodes,
    Quantization,
    add_constant,
    producer_of_input,
    quantization,
    remove_unused,
)

_LARGEST_K = 6.0
"""A larger k makes the exponential no better, and sigmoid(-k) small beside its table's steps."""


def elu_on_bytes(model: ir.Model) -> None:
    """Rewrite a QDQ graph in place; see the module.

    Args:
        model: any graph; what does not fit the pattern stays.
    """
    for elu in [node for node in model.graph if node.op_type == "Elu"]:
        dequantize = producer_of_input(elu, 0)
        if dequantize is None or dequantize.op_type != "DequantizeLinear":
            continue
        before = quantization(dequantize)
        if before is None or elu.attributes.get_float("alpha", 1.0) != 1.0:
            continue
        for quantize in elu.outputs[0].consumers():
            if quantize.op_type == "QuantizeLinear":
                _replace_input(model.graph, dequantize, before, quantize)
    remove_unused(model)


def _shift(before: Quantization, after: Quantization) -> int | None:
    """How far to move the zero point, in codes; None where the bound cannot be kept."""
    room = before.highest - before.zero_point
    shift = min(room, round(_LARGEST_K / before.scale))
    error = math.exp(-shift * before.scale) / 4 + 1 / 510
    return shift if error < after.scale else None


def _replace_input(
    graph: ir.Graph, dequantize: ir.Node, before: Quantization, quantize: ir.Node
) -> None:
    """Compute what ``quantize`` reads from the codes that ``dequantize`` reads, in place."""
    after = quantization(quantize)
    if after is None or before.dtype != after.dtype:
        return
    shift = _shift(before, after)
    if shift is None:
        return
    code = before.dtype.type
    name = str(quantize.outputs[0].name)
    codes, scale, zero_point = dequantize.inputs
    sigmoid_at_zero = 1 / (1 + math.exp(shift * before.scale))

    def constant(what: str, value: float | int, kind: type[np.generic]) -> ir.Value:
        return add_constant(graph, f"{name}/{what}", np.array(value, kind))

    new = NewNodes(quantize, name)
    moved = constant("moved_zero_point", before.zero_point + shift, code)
    shifted = new.add("DequantizeLinear", [codes, scale, moved], "shifted")
    sigmoid = new.add("Sigmoid", [shifted], "sigmoid")
    saturating = [
        constant("sigmoid_scale", sigmoid_at_zero / 255, np.float32),
        constant("lowest", before.lowest, code),
    ]
    exponential = new.add("QuantizeLinear", [sigmoid, *saturating], "exponential")
    less_one = [
        constant("exponential_scale", 1 / 255, np.float32),
        constant("highest", before.highest, code),
    ]
    negative = new.add("DequantizeLinear", [exponential, *less_one], "negative")
    clipped = new.add("Clip", [codes, zero_point], "clipped")
    positive = new.add("DequantizeLinear", [clipped, scale, zero_point], "positive")
    quantize.replace_input_with(0, new.add("Add", [positive, negative], "sum"))
