"""Stock model files: torch's exporter and onnxruntime's quantizer, without our graph passes.

Our graph passes are measured against these. Other engines get these files too, since they fuse the
graph as the exporter writes it.
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
    """Exports a network without graph passes; only the uint8 input is added.

    Args:
        network: RGB float32 (1, 3, H, W) in [0, 1] to maps, as conversions export it.
        metadata: metadata of the file; its precision decides whether to quantize.
        size: (H, W) of the input; None for any.
        images: calibration images for ``int8``, uint8 (1, H, W, 3).
        path: the file to write.
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
    """The graph of :func:`write_stock`; precision is ``fp32`` or ``int8``."""
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
