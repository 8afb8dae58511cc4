"""Pad and Resize on the codes themselves.

What it does: where a reflecting or edge Pad or a nearest Resize is followed by a QuantizeLinear,
it quantizes first and moves codes; where the codes were dequantized for the move only, both
conversions go.

Why it is faster: onnxruntime takes no DequantizeLinear and QuantizeLinear away around Pad, nor
where a Resize follows a float operator. Four times the bytes are moved, and a doubled map is
quantized at four times its size.

Bound: exact. Both operators copy values, and quantizing is by value.
"""

import onnx_ir as ir

from footprints_edge_export.graph.editing import NewNodes, needed, quantization, remove_unused


def pad_and_resize_on_bytes(model: ir.Model) -> None:
    """Rewrite a QDQ graph in place; see the module.

    Args:
        model: any graph; what does not fit the pattern stays.
    """
    for node in reversed(list(model.graph)):  # what reads a map before what makes it
        quantizes = _quantizations_after(node)
        if quantizes:
            _quantize_before(node, quantizes)
    remove_unused(model)


def _quantize_before(node: ir.Node, quantizes: list[ir.Node]) -> None:
    """Let a Pad or Resize work on codes instead of floats, in place.

    Args:
        node: the Pad or Resize.
        quantizes: the QuantizeLinears that read it, all of one quantization.
    """
    source, result = needed(node.inputs[0]), node.outputs[0]
    maker = source.producer()
    if (
        maker is not None
        and maker.op_type == "DequantizeLinear"
        and quantization(maker) == quantization(quantizes[0])
    ):
        codes = maker.inputs[0]
    else:
        name = f"codes_for/{quantizes[0].outputs[0].name}"
        parameters = quantizes[0].inputs[1:]
        codes = NewNodes(node, str(source.name)).add("QuantizeLinear", [source, *parameters], name)
    node.replace_input_with(0, codes)
    for quantize in quantizes:
        quantize.outputs[0].replace_all_uses_with(result)
    result.name = f"{result.name}/codes"
    result.type = None  # it was float


def _quantizations_after(node: ir.Node) -> list[ir.Node]:
    """The QuantizeLinears that are all that reads a Pad or Resize, if they do the same."""
    if not _copies_values(node) or node.outputs[0].is_graph_output():
        return []
    readers = list(node.outputs[0].consumers())
    kinds = {quantization(reader) for reader in readers}
    is_same = len(kinds) == 1 and None not in kinds
    are_quantizing = all(
        reader.op_type == "QuantizeLinear" and not reader.outputs[0].is_graph_output()
        for reader in readers
    )
    return readers if is_same and are_quantizing else []


def _copies_values(node: ir.Node) -> bool:
    if node.op_type == "Pad":
        return node.attributes.get_string("mode", "constant") in {"reflect", "edge"}
    mode = node.attributes.get_string("mode", "nearest")
    mapping = node.attributes.get_string("coordinate_transformation_mode", "half_pixel")
    return node.op_type == "Resize" and mode == "nearest" and mapping != "tf_crop_and_resize"
