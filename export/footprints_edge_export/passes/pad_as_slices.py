"""Reflecting and edge Pads as Slice and Concat.

What it does: each row and column that such a Pad adds is cut out of the map by a Slice and joined
to it by a Concat, axis by axis.

Why: accelerators and their compilers (NNAPI, CoreML, WebNN, WebGPU) take a Pad with zeros at best;
one they do not take cuts the network in two, and the map travels to the CPU and back.

Bound: exact. Values are copied.
"""

import numpy as np
import onnx
from onnx import helper

from footprints_edge_export.passes.rewriting import add_constant, attribute, copied, links, tidied


def pad_as_slices(model: onnx.ModelProto) -> onnx.ModelProto:
    """Rewrite every reflecting or edge Pad of known widths; see the module.

    Args:
        model: any graph; what does not fit stays.

    Returns:
        A new model; ``model`` is unchanged.
    """
    model = copied(model)
    linked = links(model.graph)
    for node in model.graph.node:
        mode = attribute(node, "mode", "constant")
        pads = linked.constant(node.input[1]) if node.op_type == "Pad" else None
        if mode not in {"reflect", "edge"} or pads is None or len(node.input) > 3:
            continue
        widths = pads.astype(int).reshape(2, -1)
        if (widths >= 0).all():
            _replace(model.graph, node, widths.T.tolist(), reflects=mode == "reflect")
    return tidied(model)


def _replace(
    graph: onnx.GraphProto, pad: onnx.NodeProto, widths: list[list[int]], *, reflects: bool
) -> None:
    """Make the Pad's output otherwise; ``tidied`` drops the Pad itself.

    Args:
        graph: changed in place.
        pad: the node.
        widths: what is added before and after, for each axis.
        reflects: whether rows are mirrored, or the outermost one is repeated.
    """
    current, result = pad.input[0], pad.output[0]
    pad.output[0] = f"{result}/replaced"
    for axis, (before, after) in enumerate(widths):
        if not before and not after:
            continue
        lead = [i if reflects else 0 for i in range(before, 0, -1)]
        trail = [-1 - i if reflects else -1 for i in range(1, after + 1)]
        rows = [_row(graph, current, axis, index) for index in lead]
        rows += [current, *(_row(graph, current, axis, index) for index in trail)]
        current = f"{result}/padded{axis}"
        graph.node.append(helper.make_node("Concat", rows, [current], name=current, axis=axis))
    graph.node.append(helper.make_node("Identity", [current], [result], name=f"{result}/same"))


def _row(graph: onnx.GraphProto, source: str, axis: int, index: int) -> str:
    """Name of one row of a tensor; negative indices count from its end."""
    end = index + 1 if index != -1 else np.iinfo(np.int64).max
    name = f"{source}/axis{axis}row{index}"
    if all(name not in node.output for node in graph.node):
        bounds = [
            add_constant(graph, f"slice_at/{value}", np.array([value], np.int64))
            for value in (index, end, axis)
        ]
        graph.node.append(helper.make_node("Slice", [source, *bounds], [name], name=name))
    return name
