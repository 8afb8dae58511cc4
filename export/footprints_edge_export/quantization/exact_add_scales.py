"""Scales of quantized sums, rounded so that every processor and browser gets the same bytes.

A runtime adds two quantized tensors as ``round(a * s_a / s_c + b * s_b / s_c)`` in float32. Where
the processor multiplies and adds in one instruction, the first product is not rounded; elsewhere it
is, and now and then a sum that lies halfway between two codes goes the other way. A few such bytes
in an early layer move the edge of what is hidden by whole pixels. With ratios of a few bits the
products are exact, and there is nothing to round differently.
"""

import math

import numpy as np
import onnx_ir as ir

from footprints_edge_export.graph.editing import (
    needed,
    numbers,
    producer_of_input,
    quantization,
    set_constant,
)

RATIO_BITS = 6
"""Binary digits of the scale of a sum, and of an addend's scale over it: at most 1/32 coarser. Four
of them fill a float32, which is as many as meet where sums of sums of sums are added."""


def make_sums_exact(model: ir.Model) -> None:
    """Round the scales of all quantized sums of a QDQ graph and of their addends, in place.

    The int32 biases of the convolutions that read such a tensor are in steps of its scale; they
    are brought to the new one.

    Args:
        model: from ``quantize_static``, nodes in an order of computation.
    """
    scales: dict[ir.Value, float] = {}
    for node in reversed(model.graph):  # a sum before its addends, which may be sums, too
        around = _scales_around(node) if node.op_type == "Add" else None
        if around is None:
            continue
        *addends, total = around
        scale = scales.setdefault(total, rounded_up(numbers(total).item()))
        for addend in addends:
            scales.setdefault(addend, scale * rounded_up(numbers(addend).item() / scale))
    for node in model.graph:
        if node.op_type == "Conv":
            _rescale_bias(node, scales)
    for value, scale in scales.items():
        set_constant(value, np.array(scale, np.float32))


def rounded_up(value: float) -> float:
    """The next number of ``RATIO_BITS`` binary digits; ``value`` is positive.

    Never down: no value is cut off that was in range, and no bias outgrows its int32.
    """
    mantissa, exponent = math.frexp(value)
    return math.ldexp(math.ceil(math.ldexp(mantissa, RATIO_BITS)), exponent - RATIO_BITS)


def _scales_around(node: ir.Node) -> list[ir.Value] | None:
    """The scales of both addends and of the sum; None where one of them is not quantized."""
    around = [producer_of_input(node, 0), producer_of_input(node, 1), *node.outputs[0].consumers()]
    if len(around) != 3 or any(quantization(each) is None for each in around):
        return None
    return [needed(each.inputs[1]) for each in around if each is not None]


def _rescale_bias(conv: ir.Node, scales: dict[ir.Value, float]) -> None:
    image, bias = producer_of_input(conv, 0), producer_of_input(conv, 2)
    if image is None or bias is None or image.op_type != "DequantizeLinear":
        return
    image_scale = needed(image.inputs[1])
    if image_scale not in scales:
        return
    steps, scale = (numbers(value) for value in bias.inputs[:2])
    grown = np.float32(scales[image_scale]) / np.float32(numbers(image_scale).item())
    set_constant(bias.inputs[0], np.rint(steps / grown).astype(np.int32))
    set_constant(bias.inputs[1], (scale * grown).astype(np.float32))
