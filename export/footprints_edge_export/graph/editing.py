"""Helpers for rewriting graphs with ``onnx_ir``: constants, quantizations, new nodes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import onnx
import onnx_ir as ir
from numpy.typing import ArrayLike, NDArray
from onnx_ir.passes.common import RemoveUnusedNodesPass


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


def constant(value: ir.Value | None) -> NDArray[Any] | None:
    """Array of an initializer; None for a tensor that is computed, and for no tensor at all."""
    if value is None or value.const_value is None:
        return None
    return value.const_value.numpy()


def constant_input(node: ir.Node, index: int) -> NDArray[Any] | None:
    """Array of a node's input; None if it is computed or left out."""
    return constant(node.inputs[index]) if index < len(node.inputs) else None


def producer_of_input(node: ir.Node, index: int) -> ir.Node | None:
    """The node that computes a node's input; None if none does, or it is left out."""
    value = node.inputs[index] if index < len(node.inputs) else None
    return None if value is None else value.producer()


def needed(value: ir.Value | None) -> ir.Value:
    """An input that a valid graph cannot leave out."""
    assert value is not None
    return value


def numbers(value: ir.Value | None) -> NDArray[Any]:
    """Array of an initializer that must be there."""
    array = constant(value)
    assert array is not None
    return array


def set_constant(value: ir.Value | None, array: NDArray[Any]) -> None:
    """Give an initializer another array, of the same shape."""
    value = needed(value)
    value.const_value = ir.tensor(array.reshape(numbers(value).shape), name=value.name)


def add_constant(graph: ir.Graph, name: str, array: ArrayLike) -> ir.Value:
    """Add an initializer, unless the graph has one of that name already."""
    if name not in graph.initializers:
        graph.register_initializer(
            ir.val(name, const_value=ir.tensor(np.asarray(array), name=name))
        )
    return graph.initializers[name]


def quantization(node: ir.Node | None) -> Quantization | None:
    """Parameters of a QuantizeLinear or DequantizeLinear with one scale; None for other nodes."""
    if node is None or node.op_type not in {"QuantizeLinear", "DequantizeLinear"}:
        return None
    scale, zero_point = constant_input(node, 1), constant_input(node, 2)
    if scale is None or zero_point is None or scale.size != 1:
        return None
    if scale.dtype != np.float32 or zero_point.dtype not in (np.uint8, np.int8):
        return None
    return Quantization(scale.item(), zero_point.item(), zero_point.dtype)


class NewNodes:
    """Nodes that are inserted right before another one, named after their outputs.

    Args:
        before: the node that they are inserted before.
        prefix: what their names begin with.
    """

    def __init__(self, before: ir.Node, prefix: str) -> None:
        self._before = before
        self._prefix = prefix

    def add(
        self,
        operator: str,
        inputs: Sequence[ir.Value | None],
        name: str,
        *,
        node_name: str | None = None,
        **attributes: int | float | str | Sequence[int],
    ) -> ir.Value:
        """Insert a node with output ``PREFIX/name``, which is its own name too by default."""
        full_name = f"{self._prefix}/{name}"
        outputs = [ir.val(full_name)]
        node = ir.node(operator, inputs, attributes, outputs=outputs, name=node_name or full_name)
        self._before.prepend(node)
        return node.outputs[0]


def replace_node(old: ir.Node, new: ir.Value, name: str | None) -> None:
    """Let a tensor take the place, and the name, of the one output of a node; drop the node.

    Args:
        old: the node.
        new: output of a node that is in the graph already.
        name: new name of the node that makes ``new``.
    """
    producer, graph = new.producer(), old.graph
    assert producer is not None
    assert isinstance(graph, ir.Graph)
    producer.name = name
    ir.convenience.replace_nodes_and_values(graph, old, [old], [], old.outputs, [new])


def remove_unused(model: ir.Model) -> None:
    """Drop nodes and initializers that no output needs, in place."""
    RemoveUnusedNodesPass()(model)


def to_proto(model: ir.Model) -> onnx.ModelProto:
    """As protobuf, without the types of intermediate tensors: rewrites do not keep them right."""
    proto = ir.to_proto(model)
    del proto.graph.value_info[:]
    return proto
