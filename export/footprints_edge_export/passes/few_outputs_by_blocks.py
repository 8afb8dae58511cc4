"""A convolution of few outputs, computed for 2x2 pixels at a time.

What it does: a stride-1 convolution of at most four output channels becomes one of stride 2 and a
kernel one wider, whose outputs are the 2x2 pixels of a block, and a DepthToSpace.

Why it is faster: onnxruntime's float convolutions compute output channels in blocks of 8 or 16; a
head of two or four channels leaves most of a block empty. A 3x3 head then costs 16 taps of
arithmetic for four pixels, where it cost 36.

Bound: float32 roundings, 1e-5 of the largest sum. Only for maps of even sides.
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

_MOST_OUTPUTS = 4


def few_outputs_by_blocks(model: onnx.ModelProto) -> onnx.ModelProto:
    """Rewrite the heads of a float32 graph; see the module.

    Args:
        model: any graph; convolutions of other kinds stay, and such of a map with a side that is
            known to be odd. Sides that are free must be even.

    Returns:
        A new model; ``model`` is unchanged.
    """
    model = copied(model)
    graph = model.graph
    linked = links(graph)
    inferred = onnx.shape_inference.infer_shapes(model).graph
    shapes = {
        value.name: [dim.dim_value for dim in value.type.tensor_type.shape.dim]
        for value in (*inferred.value_info, *inferred.output)
    }
    for node in [node for node in graph.node if _is_head(node, linked)]:
        shape = shapes.get(node.output[0])
        if shape is not None and len(shape) == 4 and not any(side % 2 for side in shape[2:]):
            _compute_by_blocks(graph, linked, node)
    return tidied(model)


def _is_head(node: onnx.NodeProto, linked: Links) -> bool:
    if node.op_type != "Conv":
        return False
    weight = linked.constant(node.input[1])
    bias = linked.constant(node.input[2]) if len(node.input) > 2 else None
    return (
        weight is not None
        and weight.ndim == 4
        and weight.dtype == np.float32
        and weight.shape[0] <= _MOST_OUTPUTS
        and (len(node.input) == 2 or bias is not None)
        and attribute(node, "group", 1) == 1
        and attribute(node, "auto_pad", "NOTSET") == "NOTSET"
        and all(attribute(node, name, [1, 1]) == [1, 1] for name in ("strides", "dilations"))
    )


def _compute_by_blocks(graph: onnx.GraphProto, linked: Links, conv: onnx.NodeProto) -> None:
    """Turn a convolution into one of whole blocks and a DepthToSpace, in place."""
    weight = linked.constant(conv.input[1])
    assert weight is not None
    outputs, inputs, height, width = weight.shape
    blocks = np.zeros((2, 2, outputs, inputs, height + 1, width + 1), np.float32)
    for row in range(2):
        for column in range(2):
            blocks[row, column, :, :, row : row + height, column : column + width] = weight
    name = conv.output[0]
    constants = [
        add_constant(
            graph, f"{name}/weight", blocks.reshape(4 * outputs, inputs, *blocks.shape[4:])
        )
    ]
    if len(conv.input) > 2:
        bias = linked.constant(conv.input[2])
        assert bias is not None
        constants.append(add_constant(graph, f"{name}/bias", np.tile(bias, 4)))
    together = f"{name}/blocks"
    graph.node.append(
        helper.make_node(
            "Conv",
            [conv.input[0], *constants],
            [together],
            conv.name,
            kernel_shape=[height + 1, width + 1],
            strides=[2, 2],
            pads=attribute(conv, "pads", [0, 0, 0, 0]),
        )
    )
    conv.CopyFrom(
        helper.make_node("DepthToSpace", [together], [name], f"{name}/pixels", blocksize=2)
    )
