"""Reflecting and edge Pads as Slice and Concat.

What it does: each row and column that such a Pad adds is cut out of the map by a Slice and joined
to it by a Concat, axis by axis.

Why: accelerators and their compilers (NNAPI, CoreML, WebNN, WebGPU) take a Pad with zeros at best;
one they do not take cuts the network in two, and the map travels to the CPU and back.

Bound: exact. Values are copied.
"""

import numpy as np
import onnx_ir as ir

from footprints_edge_export.graph.editing import (
    NewNodes,
    add_constant,
    constant_input,
    needed,
    remove_unused,
    replace_node,
)


def pad_as_slices(model: ir.Model) -> None:
    """Rewrite every reflecting or edge Pad of known widths, in place; see the module.

    Args:
        model: any graph; what does not fit stays.
    """
    for node in [node for node in model.graph if node.op_type == "Pad"]:
        mode = node.attributes.get_string("mode", "constant")
        pads = constant_input(node, 1)
        if mode not in {"reflect", "edge"} or pads is None or len(node.inputs) > 3:
            continue
        widths = pads.astype(int).reshape(2, -1)
        if (widths >= 0).all():
            _replace(model.graph, node, widths.T.tolist(), reflects=mode == "reflect")
    remove_unused(model)


def _replace(graph: ir.Graph, pad: ir.Node, widths: list[list[int]], *, reflects: bool) -> None:
    """Make the Pad's output by Slice and Concat, in place.

    Args:
        graph: the graph of the node.
        pad: the node.
        widths: number of rows to add before and after, for each axis.
        reflects: whether rows are mirrored, or the outermost one is repeated.
    """
    current, result = needed(pad.inputs[0]), pad.outputs[0].name
    for axis, (before, after) in enumerate(widths):
        if not before and not after:
            continue
        lead = [i if reflects else 0 for i in range(before, 0, -1)]
        trail = [-1 - i if reflects else -1 for i in range(1, after + 1)]
        rows = [_row(graph, pad, current, axis, index) for index in lead]
        rows += [current, *(_row(graph, pad, current, axis, index) for index in trail)]
        current = NewNodes(pad, str(result)).add("Concat", rows, f"padded{axis}", axis=axis)
    replace_node(
        pad, NewNodes(pad, str(result)).add("Identity", [current], "same"), f"{result}/same"
    )


def _row(graph: ir.Graph, pad: ir.Node, source: ir.Value, axis: int, index: int) -> ir.Value:
    """One row of a tensor; negative indices count from its end."""
    end = index + 1 if index != -1 else np.iinfo(np.int64).max
    name = f"axis{axis}row{index}"
    for reader in source.consumers():  # another Pad may have cut it out already
        if reader.name == f"{source.name}/{name}":
            return reader.outputs[0]
    bounds = [
        add_constant(graph, f"slice_at/{value}", np.array([value], np.int64))
        for value in (index, end, axis)
    ]
    return NewNodes(pad, str(source.name)).add("Slice", [source, *bounds], name)
