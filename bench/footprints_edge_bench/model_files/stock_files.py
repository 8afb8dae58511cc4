"""Model files as the stock tools leave them: torch's exporter, and onnxruntime's quantizer.

Our own rewrites of the graph are measured against these; other engines that fuse what the
exporter writes are given them.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.model_files.metadata import ModelMetadata

if TYPE_CHECKING:
    import onnx_ir as ir
    from torch import nn


def write_stock(
    network: "nn.Module",
    metadata: ModelMetadata,
    size: Size | None,
    images: Sequence[Rgb],
    path: Path,
) -> None:
    """Exports a network with no rewrite but its uint8 input.

    Args:
        network: RGB float32 (B, 3, H, W) in [0, 1] to raw channels.
        metadata: of the file; its precision decides.
        size: (H, W) of the input; None for any.
        images: for ``int8``, what it is calibrated on, uint8 (1, H, W, 3).
        path: to write to.
    """
    import onnx

    from footprints_edge_export.graph.editing import to_proto
    from footprints_edge_export.verification.contract import set_metadata

    graph = stock_graph(network, metadata.precision, size, images)
    set_metadata(graph, metadata)
    onnx.save(to_proto(graph), path)


def stock_graph(
    network: "nn.Module", precision: str, size: Size | None, images: Sequence[Rgb]
) -> "ir.Model":
    """The same as a graph; its precision is ``fp32`` or ``int8``."""
    from footprints_edge_export.graph.torch_export import to_graph
    from footprints_edge_export.graph.uint8_input import (
        correct_first_bias,
        join_uint8_image,
        join_uint8_image_quantized,
        split_normalisation,
    )
    from footprints_edge_export.quantization.quantize import quantize

    graph = to_graph(network, size)
    normalisation = split_normalisation(graph)
    if precision == "int8":
        correct_first_bias(graph, normalisation)
        graph = quantize(graph, normalisation, list(images), "x86-vnni")
        join_uint8_image_quantized(graph, normalisation)
    else:
        join_uint8_image(graph, normalisation)
    return graph
