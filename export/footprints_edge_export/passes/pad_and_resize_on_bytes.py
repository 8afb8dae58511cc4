"""Pad and Resize on the codes themselves.

What it does: where a reflecting or edge Pad or a nearest Resize is followed by a QuantizeLinear,
it quantizes first and moves codes; where the codes were dequantized for the move only, both
conversions go.

Why it is faster: onnxruntime takes no DequantizeLinear and QuantizeLinear away around Pad, nor
where a Resize follows a float operator. Four times the bytes are moved, and a doubled map is
quantized at four times its size.

Bound: exact. Both operators copy values, and quantizing is by value.
"""

import onnx
from onnx import helper

from footprints_edge_export.passes.rewriting import (
    Links,
    Quantization,
    attribute,
    copied,
    links,
    tidied,
)


def pad_and_resize_on_bytes(model: onnx.ModelProto) -> onnx.ModelProto:
    """Rewrite a QDQ graph; see the module.

    Args:
        model: any graph; what does not fit the pattern stays.

    Returns:
        A new model; ``model`` is unchanged.
    """
    model = copied(model)
    while _move_one(model.graph):
        pass
    return tidied(model)


def _move_one(graph: onnx.GraphProto) -> bool:
    """Whether there was a Pad or Resize to rewrite; it has been, in place."""
    linked = links(graph)
    for node in graph.node:
        found = _quantization_after(node, linked)
        if found is None:
            continue
        quantize, quantization = found
        source = node.input[0]
        maker = linked.makers.get(source)
        if (
            maker is not None
            and maker.op_type == "DequantizeLinear"
            and linked.quantization(maker) == quantization
        ):
            codes = maker.input[0]
        else:
            codes = f"{source}/codes_for/{quantize.output[0]}"
            graph.node.append(
                helper.make_node(
                    "QuantizeLinear", [source, *quantize.input[1:]], [codes], name=codes
                )
            )
        node.input[0] = codes
        moved = f"{node.output[0]}/codes"
        for reader in linked.readers[node.output[0]]:
            for code_reader in linked.readers.get(reader.output[0], []):
                for index, name in enumerate(code_reader.input):
                    if name == reader.output[0]:
                        code_reader.input[index] = moved
        node.output[0] = moved
        return True
    return False


def _quantization_after(
    node: onnx.NodeProto, linked: Links
) -> tuple[onnx.NodeProto, Quantization] | None:
    """The QuantizeLinear that is all that reads a Pad or Resize, and what it does."""
    if not _copies_values(node) or node.output[0] in linked.results:
        return None
    readers = linked.readers.get(node.output[0], [])
    kinds = {linked.quantization(reader) for reader in readers}
    if len(kinds) != 1 or any(
        reader.op_type != "QuantizeLinear" or reader.output[0] in linked.results
        for reader in readers
    ):
        return None
    (quantization,) = kinds
    return None if quantization is None else (readers[0], quantization)


def _copies_values(node: onnx.NodeProto) -> bool:
    if node.op_type == "Pad":
        return attribute(node, "mode", "constant") in {"reflect", "edge"}
    return (
        node.op_type == "Resize"
        and attribute(node, "mode", "nearest") == "nearest"
        and attribute(node, "coordinate_transformation_mode", "half_pixel") != "tf_crop_and_resize"
    )
