"""The front of the graph: a uint8 NHWC image in place of a float NCHW one.

A network normalises its input by scalars, ``x = slope * image + offset``. That chain is read off
the graph and said again on bytes. Where the offset is a whole number of bytes, one
DequantizeLinear says it exactly; an int8 graph then feeds the bytes straight to its first
convolution, with no float picture in between.
"""

from dataclasses import dataclass

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

from footprints_edge_export.errors import ExportError

NORMALISED = "image_normalised"
"""Name of the tensor that the network proper begins with."""


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
        """Whether a DequantizeLinear says it to float32's precision."""
        is_near = abs(self.zero_byte - self.zero_point) < 1e-5 * 255
        return is_near and 0 <= self.zero_point <= 255


def split_normalisation(model: onnx.ModelProto) -> Normalisation:
    """Cut the leading scalar arithmetic off a graph.

    The graph then begins with the float32 NCHW input ``image_normalised``.

    Args:
        model: with float32 input ``image`` [1, 3, H, W] in [0, 1]; changed in place.

    Returns:
        What was cut off, in bytes.

    Raises:
        ExportError: the arithmetic does not end in a single scale and offset.
    """
    graph = model.graph
    constants = {t.name: numpy_helper.to_array(t) for t in graph.initializer}
    slope, offset, current = 1.0, 0.0, graph.input[0].name
    while True:
        consumers = [node for node in graph.node if current in node.input]
        if len(consumers) != 1 or consumers[0].op_type not in {"Mul", "Div", "Add", "Sub"}:
            break
        node = consumers[0]
        other = constants.get(node.input[1])
        if node.input[0] != current or other is None or other.size != 1:
            raise ExportError(f"cannot read the network's normalisation from {node.op_type}")
        value = float(other.reshape(()))
        match node.op_type:
            case "Mul":
                slope, offset = slope * value, offset * value
            case "Div":
                slope, offset = slope / value, offset / value
            case "Add":
                offset += value
            case "Sub":
                offset -= value
        current = node.output[0]
        graph.node.remove(node)
    for node in graph.node:
        _rename_input(node, current, NORMALISED)
    graph.input[0].name = NORMALISED
    drop_unused_initializers(graph)
    return Normalisation(slope / 255, -offset / slope * 255)


def join_uint8_image(model: onnx.ModelProto, normalisation: Normalisation) -> None:
    """Give a float graph its uint8 input, in place: Transpose, then the normalisation."""
    graph = model.graph
    _uint8_input(graph)
    _add_constant(graph, "image_scale", np.float32(normalisation.scale))
    front = [_transpose()]
    if normalisation.is_whole:
        front.append(_dequantize(graph, "image_scale", normalisation))
    else:
        _add_constant(graph, "image_zero", np.float32(normalisation.zero_byte))
        front += [
            helper.make_node("Cast", ["image_nchw"], ["image_f"], "to_float", to=TensorProto.FLOAT),
            helper.make_node("Sub", ["image_f", "image_zero"], ["image_centred"], "centre"),
            helper.make_node("Mul", ["image_centred", "image_scale"], [NORMALISED], "scale"),
        ]
    _prepend(graph, front)


def join_uint8_image_quantized(model: onnx.ModelProto, normalisation: Normalisation) -> None:
    """Give a QDQ graph its uint8 input, in place: the bytes are the first quantized tensor.

    The graph's own quantization of ``image_normalised`` must be that of ``normalisation`` (uint8),
    or its twin one sign bit away (int8).
    """
    graph = model.graph
    (quantize,) = [n for n in graph.node if n.op_type == "QuantizeLinear" and NORMALISED in n.input]
    constants = {t.name: numpy_helper.to_array(t) for t in graph.initializer}
    zero_point = constants[quantize.input[2]]
    _uint8_input(graph)
    front = [_transpose()]
    if zero_point.dtype == np.uint8:
        for node in graph.node:
            _rename_input(node, quantize.output[0], "image_nchw")
        graph.node.remove(quantize)
    else:
        front.append(_dequantize(graph, quantize.input[1], normalisation))
    _prepend(graph, front)
    drop_unused_initializers(graph)


def correct_first_bias(model: onnx.ModelProto, normalisation: Normalisation) -> None:
    """Compensate for rounding the zero byte, in the bias of the first convolution, in place.

    The convolution will see ``scale * (byte - zero_point)``, which is too large by
    ``scale * (zero_byte - zero_point)``. Exact except at a border of the kernel's padding. A
    convolution without bias gets one.

    Raises:
        ExportError: the network does not begin with a convolution.
    """
    graph = model.graph
    shift = normalisation.scale * (normalisation.zero_byte - normalisation.zero_point)
    if normalisation.is_whole:
        return
    initializers = {tensor.name: tensor for tensor in graph.initializer}
    (conv,) = [node for node in graph.node if NORMALISED in node.input]
    if conv.op_type != "Conv":
        raise ExportError(f"int8 needs a network that begins with a Conv, not {conv.op_type}")
    weight = numpy_helper.to_array(initializers[conv.input[1]])
    if len(conv.input) < 3:  # the exporter drops a bias of zeros
        _add_constant(graph, f"{conv.input[1]}_bias", np.zeros(len(weight), np.float32))
        conv.input.append(graph.initializer[-1].name)
        initializers[conv.input[2]] = graph.initializer[-1]
    tensor = initializers[conv.input[2]]
    bias: NDArray[np.float32] = numpy_helper.to_array(tensor) - shift * weight.sum(axis=(1, 2, 3))
    tensor.CopyFrom(numpy_helper.from_array(bias.astype(np.float32), tensor.name))


def drop_unused_initializers(graph: onnx.GraphProto) -> None:
    """Remove constants that no node reads, in place."""
    used = {name for node in graph.node for name in node.input}
    kept = [tensor for tensor in graph.initializer if tensor.name in used]
    del graph.initializer[:]
    graph.initializer.extend(kept)


def _uint8_input(graph: onnx.GraphProto) -> None:
    _, _, height, width = graph.input[0].type.tensor_type.shape.dim
    shape = [1, *(d.dim_value or name for d, name in ((height, "H"), (width, "W"))), 3]
    del graph.input[:]
    graph.input.append(helper.make_tensor_value_info("image", TensorProto.UINT8, shape))
    channels = graph.output[0].type.tensor_type.shape.dim[1].dim_value
    output = [1, channels, *shape[1:3]]
    del graph.output[:]
    graph.output.append(helper.make_tensor_value_info("maps", TensorProto.FLOAT, output))


def _transpose() -> onnx.NodeProto:
    return helper.make_node("Transpose", ["image"], ["image_nchw"], "to_nchw", perm=[0, 3, 1, 2])


def _dequantize(
    graph: onnx.GraphProto, scale_name: str, normalisation: Normalisation
) -> onnx.NodeProto:
    """Bytes to ``image_normalised``, with a zero point that is added to the graph."""
    _add_constant(graph, "image_zero_point", np.uint8(normalisation.zero_point))
    inputs = ["image_nchw", scale_name, "image_zero_point"]
    return helper.make_node("DequantizeLinear", inputs, [NORMALISED], "normalise")


def _add_constant(
    graph: onnx.GraphProto, name: str, value: np.float32 | np.uint8 | NDArray[np.float32]
) -> None:
    graph.initializer.append(numpy_helper.from_array(np.array(value), name))


def _prepend(graph: onnx.GraphProto, front: list[onnx.NodeProto]) -> None:
    nodes = [*front, *graph.node]
    del graph.node[:]
    graph.node.extend(nodes)


def _rename_input(node: onnx.NodeProto, old: str, new: str) -> None:
    for index, name in enumerate(node.input):
        if name == old:
            node.input[index] = new
