"""Differences that int8 and the graph passes make to the maps of a trained network, on photos."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Size
from footprints_edge.inputs.images import decode
from footprints_edge.inputs.preprocessing import preprocess
from footprints_edge_bench.foundation.markdown import markdown_table
from footprints_edge_bench.model_files.stock_files import stock_graph
from footprints_edge_bench.passes.gains import session_of, variants

if TYPE_CHECKING:
    from footprints_edge_export.verification.compare import Difference


@dataclass(frozen=True)
class MapChange:
    """Difference between the maps of two graphs.

    Attributes:
        name: name of the graph.
        against: name of the graph that it is compared with.
        difference: difference on photos that were not used for calibration.
    """

    name: str
    against: str
    difference: "Difference"


def measure_changes(
    architecture: str,
    checkpoint: Path,
    precision: str,
    size: Size,
    photos: Sequence[Path],
    threads: int,
) -> list[MapChange]:
    """Exports a trained network with and without the passes and compares the maps.

    Photos are split as in a conversion: at most 200, one in five for the comparison, the others to
    calibrate int8.

    Args:
        architecture: key of the exporter's ``ARCHITECTURES``.
        checkpoint: trained weights.
        precision: ``fp32`` or ``int8``.
        size: (H, W).
        photos: folders of photos.
        threads: threads of onnxruntime.

    Raises:
        ExportError: a folder is missing, or has too few photos.
        ImageError: a folder holds no photo, or a photo cannot be read.
        ModelError: the checkpoint does not fit the architecture.
    """
    from footprints_edge_export.architectures import ARCHITECTURES, trained
    from footprints_edge_export.graph.editing import to_proto
    from footprints_edge_export.quantization.calibration import split_photos
    from footprints_edge_export.verification.compare import compare_maps

    network = ARCHITECTURES[architecture].part(trained(architecture, checkpoint), "all", 1).eval()
    calibration, held_out = (
        [preprocess(decode(path).rgb, size) for path in paths] for paths in split_photos(photos)
    )
    (_, exported), *_, (_, rewritten) = variants(network, precision, size, calibration)
    if precision == "fp32":
        graphs = {"float32": exported}
    else:
        exact = to_proto(stock_graph(network, "fp32", size, ()))
        graphs = {"float32": exact, f"{precision}, as exported": exported}
    graphs[f"{precision}, all passes"] = rewritten
    maps: dict[str, list[NDArray[np.float32]]] = {}
    for name, graph in graphs.items():
        session = session_of(graph, threads)
        maps[name] = [session.run(None, {"image": image})[0] for image in held_out]
    names = list(graphs)
    return [
        MapChange(b, a, compare_maps(zip(maps[a], maps[b], strict=True)))
        for i, a in enumerate(names)
        for b in names[i + 1 :]
    ]


def changes_as_markdown(changes: Sequence[MapChange]) -> str:
    """A table with one row per pair of graphs."""
    columns = [
        f"{changes[0].difference.photos} photos",
        "visible ground IoU",
        "ground IoU",
        "visible depth abs. rel.",
        "ground depth abs. rel.",
        "largest difference of a map",
    ]
    rows = [_cells(change) for change in changes]
    return markdown_table(columns, rows) + "\n"


def _cells(change: MapChange) -> list[str]:
    difference = change.difference
    return [
        f"{change.name} against {change.against}",
        f"{difference.visible_ground_iou:.4f}",
        f"{difference.ground_iou:.4f}",
        f"{difference.visible_depth_abs_rel:.4f}",
        f"{difference.ground_depth_abs_rel:.4f}",
        f"{max(difference.max_abs.values()):.2g}",
    ]
