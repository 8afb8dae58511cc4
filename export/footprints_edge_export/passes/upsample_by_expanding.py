"""Doubling a map of codes by Expand, channels last.

What it does: a nearest Resize by two of uint8 or int8 becomes Transpose to channels last,
Unsqueeze, Expand, Reshape, and Transpose back.

Why it is faster: onnxruntime runs quantized convolutions channels last, so the Transposes cancel
against its own; its nearest Resize then goes byte by byte, where Expand copies whole pixels.

Bound: exact.
"""

import numpy as np
import onnx
from onnx import helper

from footprints_edge_export.passes.rewriting import (
    Links,
    add_constant,
    attribute,
    copied,
    links,
    tidied,
)


def upsample_by_expanding(model: onnx.ModelProto) -> onnx.ModelProto:
    """Rewrite a QDQ graph in which Resize works on codes; see the module.

    Args:
        model: from :func:`pad_and_resize_on_bytes`; what does not fit the pattern stays.

    Returns:
        A new model; ``model`` is unchanged.
    """
    model = copied(model)
    graph = model.graph
    linked = links(graph)
    for resize in [node for node in graph.node if _doubles_codes(node, linked)]:
        _expand(graph, resize)
    return tidied(model)


def _doubles_codes(node: onnx.NodeProto, linked: Links) -> bool:
    if node.op_type != "Resize" or len(node.input) != 3:
        return False
    maker = linked.makers.get(node.input[0])
    scales = linked.constant(node.input[2])
    return (
        maker is not None
        and maker.op_type == "QuantizeLinear"
        and scales is not None
        and scales.tolist() == [1, 1, 2, 2]
        and attribute(node, "mode", "nearest") == "nearest"
        and attribute(node, "nearest_mode", "round_prefer_floor") == "floor"
        and attribute(node, "coordinate_transformation_mode", "half_pixel") == "asymmetric"
    )


def _expand(graph: onnx.GraphProto, resize: onnx.NodeProto) -> None:
    """Turn a Resize into its five operators and two on its shape, in place."""
    name = resize.output[0]
    pixels, small, spread = f"{name}/pixels", f"{name}/small", f"{name}/spread"
    shape, doubled, large = f"{name}/shape", f"{name}/doubled", f"{name}/large"
    between = add_constant(graph, "upsample/axes", np.array([2, 4], np.int64))
    twice = add_constant(graph, "upsample/twice", np.array([1, 1, 2, 1, 2, 1], np.int64))
    factors = add_constant(graph, "upsample/factors", np.array([1, 2, 2, 1], np.int64))
    make = helper.make_node
    graph.node.extend(
        [
            make("Transpose", [resize.input[0]], [pixels], pixels, perm=[0, 2, 3, 1]),
            make("Shape", [pixels], [shape], shape),
            make("Mul", [shape, factors], [doubled], doubled),
            make("Unsqueeze", [pixels, between], [small], small),
            make("Expand", [small, twice], [spread], spread),
            make("Reshape", [spread, doubled], [large], large),
        ]
    )
    resize.CopyFrom(make("Transpose", [large], [name], resize.name, perm=[0, 3, 1, 2]))
