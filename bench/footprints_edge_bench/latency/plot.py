"""Plot of latency against accuracy."""

from pathlib import Path
from typing import Any

from footprints_edge_bench.latency.report import LatencyReport, LatencyRow

_COLOURS = {
    "onnxruntime": "#1b6ca8",
    "torch": "#c1440e",
    "openvino": "#5b2a86",
    "ncnn": "#2f7d32",
    "litert": "#8a6d00",
}
_MARKERS = {
    "fp32": "o",
    "bf16": "D",
    "int8": "s",
    "int8-nncf": "^",
    "int8-stock": "X",
    "fp32-stock": "P",
}


def draw(report: LatencyReport, path: Path) -> None:
    """Draws the rows that ran, one panel per network and size, as PNG.

    The x axis is the median time, logarithmic. The y axis is the mean relative error of the visible
    depth against float32. The lower left corner is best.
    """
    from matplotlib.figure import Figure

    panels: dict[str, list[LatencyRow]] = {}
    for row in report.rows:
        if row.summary is not None and row.accuracy is not None:
            height, width = row.backend.size
            if row.accuracy["visible_depth_abs_rel"] is None:
                continue
            panels.setdefault(f"{row.backend.network} {height}x{width}", []).append(row)
    figure = Figure(figsize=(4.2 * max(1, len(panels)), 4.4), layout="constrained")
    figure.suptitle(f"Network alone, {report.threads} thread(s), {report.machine.cpu}", fontsize=10)
    labels: dict[str, Any] = {}
    for index, (title, rows) in enumerate(panels.items()):
        axes = figure.add_subplot(1, len(panels), index + 1)
        for row in rows:
            assert row.summary is not None
            assert row.accuracy is not None
            summary, backend = row.summary, row.backend
            axes.errorbar(
                summary.p50_ms,
                100 * float(row.accuracy["visible_depth_abs_rel"]),
                xerr=[[summary.p50_ms - summary.min_ms], [summary.p90_ms - summary.p50_ms]],
                fmt=_MARKERS.get(backend.precision, "o"),
                color=_COLOURS.get(backend.engine, "black"),
                label=f"{backend.engine} {backend.precision}",
                markersize=7,
                capsize=2,
                alpha=0.85,
            )
        axes.set_xscale("log")
        axes.set_yscale("symlog", linthresh=0.001)
        axes.set_ylim(-0.0005, 30)
        axes.set_title(title, fontsize=10)
        axes.set_xlabel("median ms per frame (bar: fastest to 90th percentile)", fontsize=8)
        if index == 0:
            axes.set_ylabel("depth error against float32, %", fontsize=8)
        axes.grid(visible=True, which="both", alpha=0.25)
        axes.tick_params(labelsize=8)
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            labels.setdefault(label, handle)
    figure.legend(labels.values(), labels.keys(), loc="outside lower center", ncols=4, fontsize=8)
    figure.savefig(path, dpi=130)
