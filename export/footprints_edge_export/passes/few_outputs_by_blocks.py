"""A convolution of few outputs, computed for 2x2 pixels at a time.

What it does: a stride-1 convolution of at most four output channels becomes one of stride 2 and a
kernel one wider, whose outputs are the 2x2 pixels of a block, and a DepthToSpace.

Why it is faster: onnxruntime's float convolutions compute output channels in blocks of 8 or 16; a
head of two or four channels leaves most of a block empty. A 3x3 head then costs 16 taps of
arithmetic for four pixels, where it cost 36.

Bound: float32 roundings, 1e-5 of the largest sum. Only for maps of even sides.
"""

import numpy as np
import onnx_ir as ir
from onnx_ir.passes.common import ShapeInferencePass

from footprints_edge_export.graph.editing import (
    NewNodes,
    add_constant,
    constant_input,
    remove_unused,
    replace_node,
)

_MOST_OUTPUTS = 4


def few_outputs_by_blocks(model: ir.Model) -> None:
    """Rewrite the heads of a float32 graph, in place; see the module.

    Args:
        model: any graph; convolutions of other kinds stay, as do those of a map with a side that
            is known to be odd. Sides that are free must be even.
    """
    ShapeInferencePass()(model)
    for node in [node for node in model.graph if _is_head(node)]:
        shape = node.outputs[0].shape
        if shape is None or len(shape) != 4:
            continue
        if not any(isinstance(side, int) and side % 2 for side in (shape[2], shape[3])):
            _compute_by_blocks(model.graph, node)
    remove_unused(model)


def _is_head(node: ir.Node) -> bool:
    if node.op_type != "Conv":
        return False
    weight = constant_input(node, 1)
    ones = (
        node.attributes.get_ints("strides", [1, 1]),
        node.attributes.get_ints("dilations", [1, 1]),
    )
    return (
        weight is not None
        and weight.ndim == 4
        and weight.dtype == np.float32
        and weight.shape[0] <= _MOST_OUTPUTS
        and (len(node.inputs) == 2 or constant_input(node, 2) is not None)
        and node.attributes.get_int("group", 1) == 1
        and node.attributes.get_string("auto_pad", "NOTSET") == "NOTSET"
        and all(list(each) == [1, 1] for each in ones)
    )


def _compute_by_blocks(graph: ir.Graph, conv: ir.Node) -> None:
    """Turn a convolution into one of whole blocks and a DepthToSpace, in place."""
    weight, bias = constant_input(conv, 1), constant_input(conv, 2)
    assert weight is not None
    outputs, inputs, height, width = weight.shape
    blocks = np.zeros((2, 2, outputs, inputs, height + 1, width + 1), np.float32)
    for row in range(2):
        for column in range(2):
            blocks[row, column, :, :, row : row + height, column : column + width] = weight
    name = str(conv.outputs[0].name)
    kernel = blocks.reshape(4 * outputs, inputs, *blocks.shape[4:])
    constants = [add_constant(graph, f"{name}/weight", kernel)]
    if bias is not None:
        constants.append(add_constant(graph, f"{name}/bias", np.tile(bias, 4)))
    new = NewNodes(conv, name)
    blocks_of_pixels = new.add(
        "Conv",
        [conv.inputs[0], *constants],
        "blocks",
        node_name=conv.name,
        kernel_shape=[height + 1, width + 1],
        strides=[2, 2],
        pads=conv.attributes.get_ints("pads", [0, 0, 0, 0]),
    )
    pixels = new.add("DepthToSpace", [blocks_of_pixels], "pixels", blocksize=2)
    replace_node(conv, pixels, f"{name}/pixels")
