"""Doubling a map of codes by Expand, channels last.

What it does: a nearest Resize by two of uint8 or int8 becomes Transpose to channels last,
Unsqueeze, Expand, Reshape, and Transpose back.

Why it is faster: onnxruntime runs quantized convolutions channels last, so the Transposes cancel
against its own; its nearest Resize then goes byte by byte, where Expand copies whole pixels.

Bound: exact.
"""

import numpy as np
import onnx_ir as ir

from footprints_edge_export.graph.editing import (
    NewNodes,
    add_constant,
    constant_input,
    producer_of_input,
    remove_unused,
    replace_node,
)


def upsample_by_expanding(model: ir.Model) -> None:
    """Rewrite a QDQ graph in which Resize works on codes, in place; see the module.

    Args:
        model: from :func:`pad_and_resize_on_bytes`; what does not fit the pattern stays.
    """
    for resize in [node for node in model.graph if _doubles_codes(node)]:
        _expand(model.graph, resize)
    remove_unused(model)


def doubles_nearest(node: ir.Node) -> bool:
    """Whether a node is a Resize that repeats every row and column of a map."""
    if node.op_type != "Resize" or len(node.inputs) != 3:
        return False
    scales, attributes = constant_input(node, 2), node.attributes
    return (
        scales is not None
        and scales.tolist() == [1, 1, 2, 2]
        and attributes.get_string("mode", "nearest") == "nearest"
        and attributes.get_string("nearest_mode", "round_prefer_floor") == "floor"
        and attributes.get_string("coordinate_transformation_mode", "half_pixel") == "asymmetric"
    )


def _doubles_codes(node: ir.Node) -> bool:
    maker = producer_of_input(node, 0)
    return maker is not None and maker.op_type == "QuantizeLinear" and doubles_nearest(node)


def _expand(graph: ir.Graph, resize: ir.Node) -> None:
    """Turn a Resize into its five operators and two on its shape, in place."""
    between = add_constant(graph, "upsample/axes", np.array([2, 4], np.int64))
    twice = add_constant(graph, "upsample/twice", np.array([1, 1, 2, 1, 2, 1], np.int64))
    factors = add_constant(graph, "upsample/factors", np.array([1, 2, 2, 1], np.int64))
    new = NewNodes(resize, str(resize.outputs[0].name))
    pixels = new.add("Transpose", [resize.inputs[0]], "pixels", perm=[0, 2, 3, 1])
    shape = new.add("Shape", [pixels], "shape")
    doubled = new.add("Mul", [shape, factors], "doubled")
    small = new.add("Unsqueeze", [pixels, between], "small")
    spread = new.add("Expand", [small, twice], "spread")
    large = new.add("Reshape", [spread, doubled], "large")
    replace_node(resize, new.add("Transpose", [large], "planes", perm=[0, 3, 1, 2]), resize.name)
