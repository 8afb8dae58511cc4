"""The front of the graph: a uint8 NHWC image in place of a float NCHW one.

A network normalises its input by scalars, ``x = slope * image + offset``. That chain is read off
the graph and expressed on bytes. Where the offset is a whole number of bytes, one DequantizeLinear
expresses it exactly; an int8 graph then feeds the bytes straight to its first convolution, with no
float image in between.
"""

from dataclasses import dataclass

import numpy as np
import onnx_ir as ir

from footprints_edge_export.errors import ExportError
from footprints_edge_export.graph.editing import (
    add_constant,
    constant_input,
    needed,
    remove_unused,
    set_constant,
)

NORMALISED = "image_normalised"
"""Name of the tensor behind the normalisation."""


@dataclass(frozen=True)
class Normalisation:
    """``x = scale * (byte - zero_byte)``."""

    scale: float
    zero_byte: float

    @property
    def zero_point(self) -> int:
        """The nearest whole byte."""
        return round(self.zero_byte)

    @property
    def is_whole(self) -> bool:
        """Whether a DequantizeLinear expresses it to float32's precision."""
        is_near = abs(self.zero_byte - self.zero_point) < 1e-5 * 255
        return is_near and 0 <= self.zero_point <= 255


def split_normalisation(model: ir.Model) -> Normalisation:
    """Cut the leading scalar arithmetic off a graph.

    The graph then begins with the float32 NCHW input ``image_normalised``.

    Args:
        model: with float32 input ``image`` [1, 3, H, W] in [0, 1]; changed in place.

    Returns:
        The normalisation that was cut off, in bytes.

    Raises:
        ExportError: the arithmetic is not a single scale and offset.
    """
    image = model.graph.inputs[0]
    slope, offset, current = 1.0, 0.0, image
    while True:
        consumers = current.consumers()
        if len(consumers) != 1 or consumers[0].op_type not in {"Mul", "Div", "Add", "Sub"}:
            break
        node = consumers[0]
        other = constant_input(node, 1)
        if node.inputs[0] is not current or other is None or other.size != 1:
            raise ExportError(f"cannot read the network's normalisation from {node.op_type}")
        value = float(other.item())
        match node.op_type:
            case "Mul":
                slope, offset = slope * value, offset * value
            case "Div":
                slope, offset = slope / value, offset / value
            case "Add":
                offset += value
            case "Sub":
                offset -= value
        current = node.outputs[0]
    if current is not image:
        current.replace_all_uses_with(image)
    image.name = NORMALISED
    remove_unused(model)
    return Normalisation(slope / 255, -offset / slope * 255)


def join_uint8_image(model: ir.Model, normalisation: Normalisation) -> None:
    """Give a float graph its uint8 input, in place: Transpose, then the normalisation."""
    graph = model.graph
    normalised, front = graph.inputs[0], _Front(graph)
    scale = add_constant(graph, "image_scale", np.float32(normalisation.scale))
    if normalisation.is_whole:
        result = front.dequantized(scale, normalisation)
    else:
        zero = add_constant(graph, "image_zero", np.float32(normalisation.zero_byte))
        floats = front.add("Cast", [front.planes], "image_f", "to_float", to=ir.DataType.FLOAT)
        centred = front.add("Sub", [floats, zero], "image_centred", "centre")
        result = front.add("Mul", [centred, scale], NORMALISED, "scale")
    normalised.replace_all_uses_with(result)
    front.join()


def join_uint8_image_quantized(model: ir.Model, normalisation: Normalisation) -> None:
    """Give a QDQ graph its uint8 input, in place: the bytes are the first quantized tensor.

    The graph's own quantization of ``image_normalised`` must be that of ``normalisation`` (uint8),
    or its twin one sign bit away (int8).
    """
    graph = model.graph
    normalised, front = graph.inputs[0], _Front(graph)
    (quantize,) = [n for n in normalised.consumers() if n.op_type == "QuantizeLinear"]
    zero_point, scale = constant_input(quantize, 2), quantize.inputs[1]
    assert zero_point is not None
    assert scale is not None
    if zero_point.dtype == np.uint8:
        quantize.outputs[0].replace_all_uses_with(front.planes)
    else:
        normalised.replace_all_uses_with(front.dequantized(scale, normalisation))
    front.join()
    remove_unused(model)


def correct_first_bias(model: ir.Model, normalisation: Normalisation) -> None:
    """Compensate for rounding the zero byte, in the bias of the first convolution, in place.

    The convolution will see ``scale * (byte - zero_point)``, which is too large by
    ``scale * (zero_byte - zero_point)``. Exact except at a border of the kernel's padding. A
    convolution without bias gets one.

    Raises:
        ExportError: the network does not begin with a convolution.
    """
    shift = normalisation.scale * (normalisation.zero_byte - normalisation.zero_point)
    if normalisation.is_whole:
        return
    (conv,) = model.graph.inputs[0].consumers()
    weight, bias = constant_input(conv, 1), constant_input(conv, 2)
    if conv.op_type != "Conv" or weight is None:
        raise ExportError(f"int8 needs a network that begins with a Conv, not {conv.op_type}")
    if bias is None:  # the exporter drops a bias of zeros
        bias = np.zeros(len(weight), np.float32)
        conv.resize_inputs(3)
        name = f"{needed(conv.inputs[1]).name}_bias"
        conv.replace_input_with(2, add_constant(model.graph, name, bias))
    set_constant(conv.inputs[2], (bias - shift * weight.sum(axis=(1, 2, 3))).astype(np.float32))


class _Front:
    """The nodes between the uint8 NHWC input and the network, and the graph's new signature."""

    def __init__(self, graph: ir.Graph) -> None:
        self._graph = graph
        self._first = graph[0]
        given, output = graph.inputs[0].shape, graph.outputs[0]
        assert given is not None
        assert output.shape is not None
        height, width = (
            side if isinstance(side, int) else name
            for side, name in zip(given[2:], ("H", "W"), strict=True)
        )
        self._image = ir.val("image", ir.DataType.UINT8, [1, height, width, 3])
        output.name, output.dtype = "maps", ir.DataType.FLOAT
        output.shape = ir.Shape([1, output.shape[1], height, width])
        self.planes = self.add(
            "Transpose", [self._image], "image_nchw", "to_nchw", perm=[0, 3, 1, 2]
        )

    def add(
        self,
        operator: str,
        inputs: list[ir.Value],
        output: str,
        name: str,
        **attributes: int | list[int],
    ) -> ir.Value:
        """Insert a node before the network's first."""
        node = ir.node(operator, inputs, attributes, outputs=[ir.val(output)], name=name)
        self._first.prepend(node)
        return node.outputs[0]

    def dequantized(self, scale: ir.Value, normalisation: Normalisation) -> ir.Value:
        """Bytes to ``image_normalised``, with a zero point that is added to the graph."""
        zero = np.uint8(normalisation.zero_point)
        zero_point = add_constant(self._graph, "image_zero_point", zero)
        inputs = [self.planes, scale, zero_point]
        return self.add("DequantizeLinear", inputs, NORMALISED, "normalise")

    def join(self) -> None:
        """Make ``image`` the graph's input."""
        self._graph.inputs[:] = [self._image]
