"""What int8 and the graph passes change in the maps of a trained network, on photos."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Size
from footprints_edge.inputs.images import decode
from footprints_edge.inputs.preprocessing import preprocess
from footprints_edge_bench.model_files.stock_files import stock_graph
from footprints_edge_bench.passes.gains import session_of, variants

if TYPE_CHECKING:
    from footprints_edge_export.verification.compare import Difference


@dataclass(frozen=True)
class Change:
    """A file's maps against another's.

    Attributes:
        name: of the file.
        against: of the other.
        difference: on photos that nothing was calibrated on.
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
) -> list[Change]:
    """Export a trained network, with and without the passes, and compare the maps.

    Photos are taken as a conversion takes them: at most 200, one in five of them to judge by, the
    others for int8's ranges.

    Args:
        architecture: key of the exporter's ``ARCHITECTURES``.
        checkpoint: its weights.
        precision: ``fp32`` or ``int8``.
        size: (H, W).
        photos: folders.
        threads: of onnxruntime.

    Raises:
        ExportError: a folder is missing, or has too few photos.
        ImageError: one holds no photo, or one that cannot be read.
        ModelError: the checkpoint is not one of the architecture.
    """
    from footprints_edge_export.architectures import trained
    from footprints_edge_export.graph.editing import to_proto
    from footprints_edge_export.quantization.calibration import split_photos
    from footprints_edge_export.verification.compare import compare_maps

    network = trained(architecture, checkpoint)
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
        Change(b, a, compare_maps(zip(maps[a], maps[b], strict=True)))
        for i, a in enumerate(names)
        for b in names[i + 1 :]
    ]


def changes_as_markdown(changes: Sequence[Change]) -> str:
    """A table, one pair of files a row."""
    photos = changes[0].difference.photos
    lines = [
        f"| {photos} photos | visible ground IoU | ground IoU | visible depth, mean relative "
        "difference | ground depth, the same | largest difference of a map |",
        "| --- | ---: | ---: | ---: | ---: | ---: |",
    ]
    for change in changes:
        d = change.difference
        lines.append(
            f"| {change.name} against {change.against} | {d.visible_ground_iou:.4f} "
            f"| {d.ground_iou:.4f} | {d.visible_depth_abs_rel:.4f} | {d.ground_depth_abs_rel:.4f} "
            f"| {max(d.max_abs.values()):.2g} |"
        )
    return "\n".join(lines) + "\n"
