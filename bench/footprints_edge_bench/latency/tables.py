"""The latency report as Markdown and JSON."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from footprints_edge_bench.foundation.markdown import markdown_table
from footprints_edge_bench.latency.cold_start import ColdStart
from footprints_edge_bench.latency.end_to_end import EndToEnd
from footprints_edge_bench.latency.report import LatencyReport, LatencyRow

_COLUMNS = (
    "row",
    "ran in",
    "p50 ms",
    "p90",
    "p99",
    "min",
    "n",
    "CPU s",
    "speed-up (95 %)",
    "MB",
    "ground IoU",
    "depth error",
)


def as_markdown(report: LatencyReport, frames: Sequence[EndToEnd], cold: ColdStart | None) -> str:
    """The report as Markdown."""
    parts = ["## Latency", _conditions(report)]
    for size in dict.fromkeys(row.backend.size for row in report.rows):
        rows = [row for row in report.rows if row.backend.size == size]
        parts += [f"### Network alone, {size[0]}x{size[1]}", _network_table(report, rows)]
    if missing := [row for row in report.rows if row.reason]:
        parts.append("\n".join(["Not run:", "", *(f"- {r.name}: {r.reason}" for r in missing)]))
    if frames:
        parts += ["### From the bytes of a JPEG to maps in metres", _frame_table(frames)]
    if cold is not None:
        parts += ["### Cold start, fresh processes", cold.as_markdown()]
    parts.append(report.machine.as_markdown())
    return "\n\n".join(parts) + "\n"


def as_json(report: LatencyReport, frames: Sequence[EndToEnd], cold: ColdStart | None) -> str:
    """The report as JSON, with every single time."""
    content = {
        **asdict(report),
        "end_to_end": [asdict(each) for each in frames],
        "cold_start": None if cold is None else asdict(cold),
    }
    return json.dumps(content, indent=1) + "\n"


def _conditions(report: LatencyReport) -> str:
    return (
        f"One frame at a time on {report.threads} thread(s), onnxruntime's spinning: "
        f"{report.spinning}. Rows of one size are timed in turns in random order, {report.trials} "
        "rounds, after a warm-up of each. Every row computes the same four maps from the same "
        "bytes; rows named masks or depths compute two of them, rows named scale use a coarser "
        "decoder scale. Accuracy is against the stock float32 file in onnxruntime on "
        f"{report.photos}: IoU of ground, mean relative error of the visible depth. The reference "
        "network has calibrated random weights. Stock files lack our graph passes. Parts and "
        "coarser scales are compared with float32 of the same part or scale."
    )


def _network_table(report: LatencyReport, rows: Sequence[LatencyRow]) -> str:
    cells = []
    for row in rows:
        if row.summary is None:
            continue
        s, accuracy = row.summary, row.accuracy
        cells.append(
            [
                row.name,
                row.precision or "",
                f"{s.p50_ms:.1f}",
                f"{s.p90_ms:.1f}",
                f"{s.p99_ms:.1f}",
                f"{s.min_ms:.1f}",
                str(s.n),
                f"{s.cpu_s:.3f}",
                _speed_up(report, row),
                "-" if row.file_bytes is None else f"{row.file_bytes / 1e6:.1f}",
                _cell(accuracy, "ground_iou", ".4f"),
                _cell(accuracy, "visible_depth_abs_rel", ".2%"),
            ]
        )
    if not cells:
        return "No row of this size ran."
    baseline = report.baseline(rows[0].backend.size)
    note = "" if baseline is None else f"\n\nSpeed-up over: {baseline.name}."
    return markdown_table(_COLUMNS, cells, left=2) + note


def _cell(accuracy: dict[str, Any] | None, key: str, form: str) -> str:
    return "-" if accuracy is None or accuracy[key] is None else format(accuracy[key], form)


def _speed_up(report: LatencyReport, row: LatencyRow) -> str:
    baseline = report.baseline(row.backend.size)
    if baseline is None or baseline.name == row.name:
        return "1"
    found = report.ratios[baseline.name][row.name]
    return f"{found.value:.2f} ({found.low:.2f} to {found.high:.2f})"


def _frame_table(found: Sequence[EndToEnd]) -> str:
    stages = list(found[0].stages_ms)
    columns = [
        "model",
        *(f"{stage} ms" for stage in stages),
        "total p50",
        "total p90",
        "total min",
        "n",
    ]
    rows = [
        [
            each.model,
            *(f"{each.stages_ms[stage]:.1f}" for stage in stages),
            f"{each.total.p50_ms:.1f}",
            f"{each.total.p90_ms:.1f}",
            f"{each.total.min_ms:.1f}",
            str(each.total.n),
        ]
        for each in found
    ]
    first = found[0]
    height, width = first.image_size
    return markdown_table(columns, rows) + (
        f"\n\nSynthetic photo, {width} x {height}, {first.jpeg_bytes / 1e6:.1f} MB. Each stage is "
        "a median of its own."
    )
