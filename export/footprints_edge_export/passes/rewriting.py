"""What every rewrite needs: who makes and who reads a tensor, and a tidy graph afterwards."""

from dataclasses import dataclass

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import numpy_helper


@dataclass(frozen=True)
class Links:
    """Who makes and who reads the tensors of a graph, at the time of :func:`links`.

    Attributes:
        makers: node by the name of its output.
        readers: nodes by the name of what they read.
        constants: initializers by name.
        results: names of the graph's outputs.
    """

    makers: dict[str, onnx.NodeProto]
    readers: dict[str, list[onnx.NodeProto]]
    constants: dict[str, onnx.TensorProto]
    results: frozenset[str]

    def constant(self, name: str) -> NDArray[np.generic] | None:
        """Value of an initializer; None where the tensor is computed."""
        tensor = self.constants.get(name)
        return None if tensor is None else np.asarray(numpy_helper.to_array(tensor))

    def quantization(self, node: onnx.NodeProto) -> "Quantization | None":
        """Of a QuantizeLinear or DequantizeLinear with one scale for the tensor, else None."""
        if node.op_type not in {"QuantizeLinear", "DequantizeLinear"} or len(node.input) < 3:
            return None
        scale, zero_point = self.constant(node.input[1]), self.constant(node.input[2])
        if scale is None or zero_point is None or scale.size != 1:
            return None
        if scale.dtype != np.float32 or zero_point.dtype not in (np.uint8, np.int8):
            return None
        return Quantization(
            float(scale.reshape(())), int(zero_point.reshape(())), np.dtype(zero_point.dtype)
        )


@dataclass(frozen=True)
class Quantization:
    """``x = scale * (code - zero_point)``; codes are uint8 or int8."""

    scale: float
    zero_point: int
    dtype: "np.dtype[np.generic]"

    @property
    def lowest(self) -> int:
        """The lowest code."""
        return 0 if self.dtype == np.uint8 else -128

    @property
    def highest(self) -> int:
        """The highest code."""
        return self.lowest + 255


def copied(model: onnx.ModelProto) -> onnx.ModelProto:
    """A copy to rewrite, so that what was given stays as it is."""
    copy = onnx.ModelProto()
    copy.CopyFrom(model)
    return copy


def links(graph: onnx.GraphProto) -> Links:
    """Index a graph."""
    readers: dict[str, list[onnx.NodeProto]] = {}
    for node in graph.node:
        for name in dict.fromkeys(node.input):
            readers.setdefault(name, []).append(node)
    return Links(
        {name: node for node in graph.node for name in node.output},
        readers,
        {tensor.name: tensor for tensor in graph.initializer},
        frozenset(value.name for value in graph.output),
    )


def attribute(node: onnx.NodeProto, name: str, default: object = None) -> object:
    """Value of a node's attribute; text as str."""
    for found in node.attribute:
        if found.name == name:
            value = onnx.helper.get_attribute_value(found)
            return value.decode() if isinstance(value, bytes) else value
    return default


def add_constant(graph: onnx.GraphProto, name: str, value: NDArray[np.generic]) -> str:
    """Add an initializer, unless one of that name is there already; returns the name."""
    if all(tensor.name != name for tensor in graph.initializer):
        graph.initializer.append(numpy_helper.from_array(value, name))
    return name


def tidied(model: onnx.ModelProto) -> onnx.ModelProto:
    """Drop what no output needs and put the nodes in an order of computation, in place.

    Returns:
        The same model.
    """
    graph = model.graph
    makers = {name: index for index, node in enumerate(graph.node) for name in node.output}
    order: list[int] = []
    begun: set[int] = set()
    waiting = [(makers[value.name], False) for value in reversed(graph.output)]
    while waiting:
        index, inputs_done = waiting.pop()
        if inputs_done:
            order.append(index)
        elif index not in begun:
            begun.add(index)
            waiting.append((index, True))
            inputs = graph.node[index].input
            waiting += [(makers[name], False) for name in reversed(inputs) if name in makers]
    nodes = [graph.node[index] for index in order]
    kept = onnx.GraphProto()
    kept.node.extend(nodes)
    del graph.node[:]
    graph.node.extend(kept.node)
    read = {name for node in graph.node for name in node.input}
    read |= {value.name for value in graph.output}
    constants = onnx.GraphProto()
    constants.initializer.extend(t for t in graph.initializer if t.name in read)
    del graph.initializer[:]
    graph.initializer.extend(constants.initializer)
    del graph.value_info[:]
    return model
