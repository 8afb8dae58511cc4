"""Scales of quantized sums, rounded so that every processor and browser gets the same bytes.

A runtime adds two quantized tensors as ``round(a * s_a / s_c + b * s_b / s_c)`` in float32. Where
the processor multiplies and adds in one instruction, the first product is not rounded; elsewhere it
is, and now and then a sum that lies halfway between two codes goes the other way. A few such bytes
in an early layer move the edge of what is hidden by whole pixels. With ratios of a few bits the
products are exact, and there is nothing to round differently.
"""

import math

import numpy as np
import onnx
from onnx import numpy_helper

from footprints_edge_export.passes.rewriting import Links, links

RATIO_BITS = 6
"""Of the scale of a sum, and of an addend's scale over it: at most 1/32 coarser. Four of them fill
a float32, which is as many as meet where sums of sums of sums are added."""


def make_sums_exact(model: onnx.ModelProto) -> None:
    """Round the scales of all quantized sums of a QDQ graph and of what they add, in place.

    The int32 biases of the convolutions that read such a tensor are in steps of its scale; they
    are brought to the new one.

    Args:
        model: from ``quantize_static``, nodes in an order of computation.
    """
    found = links(model.graph)
    scales: dict[str, float] = {}
    for node in reversed(model.graph.node):  # a sum before what it adds, which may be sums, too
        names = _scale_names(found, node) if node.op_type == "Add" else None
        if names is None:
            continue
        *addends, total = names
        scale = scales.setdefault(total, rounded_up(_scale(found, total)))
        for name in addends:
            scales.setdefault(name, scale * rounded_up(_scale(found, name) / scale))
    for node in model.graph.node:
        if node.op_type == "Conv":
            _rescale_bias(found, node, scales)
    for name, scale in scales.items():
        _set(found, name, np.array(scale, np.float32))


def rounded_up(value: float) -> float:
    """The next number of ``RATIO_BITS`` binary digits; ``value`` is positive.

    Never down: no value is cut off that was in range, and no bias outgrows its int32.
    """
    mantissa, exponent = math.frexp(value)
    return math.ldexp(math.ceil(math.ldexp(mantissa, RATIO_BITS)), exponent - RATIO_BITS)


def _scale_names(found: Links, node: onnx.NodeProto) -> list[str] | None:
    """Names of the scales of both addends and of the sum; None where one is not quantized."""
    around = [found.makers.get(name) for name in node.input]
    around += found.readers.get(node.output[0], [])
    if len(around) != 3 or any(each is None or not found.quantization(each) for each in around):
        return None
    return [each.input[1] for each in around if each is not None]


def _scale(found: Links, name: str) -> float:
    return float(numpy_helper.to_array(found.constants[name]).reshape(()))


def _set(found: Links, name: str, value: np.ndarray) -> None:
    shape = tuple(found.constants[name].dims)
    found.constants[name].CopyFrom(numpy_helper.from_array(value.reshape(shape), name))


def _rescale_bias(found: Links, node: onnx.NodeProto, scales: dict[str, float]) -> None:
    image, bias = (found.makers.get(name) for name in (node.input[0], [*node.input, ""][2]))
    if image is None or bias is None or image.op_type != "DequantizeLinear":
        return
    if image.input[1] not in scales:
        return
    steps, scale = (numpy_helper.to_array(found.constants[name]) for name in bias.input[:2])
    grown = np.float32(scales[image.input[1]]) / np.float32(_scale(found, image.input[1]))
    _set(found, bias.input[0], np.rint(steps / grown).astype(np.int32))
    _set(found, bias.input[1], (scale * grown).astype(np.float32))
