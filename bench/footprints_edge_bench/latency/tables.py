"""The latency benchmark's report, in Markdown and as JSON."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from footprints_edge_bench.latency.benchmark import LatencyReport, LatencyRow
from footprints_edge_bench.latency.cold_start import ColdStart
from footprints_edge_bench.latency.end_to_end import EndToEnd

_COLUMNS = (
    "row",
    "ran in",
    "p50 ms",
    "p90",
    "p99",
    "min",
    "n",
    "CPU s",
    "times as fast (95 %)",
    "MB",
    "ground IoU",
    "depth error",
)


def markdown(report: LatencyReport, end_to_end: Sequence[EndToEnd], cold: ColdStart | None) -> str:
    """The whole report."""
    parts = ["## Latency", _conditions(report)]
    for size in dict.fromkeys(row.backend.size for row in report.rows):
        rows = [row for row in report.rows if row.backend.size == size]
        parts += [f"### Network alone, {size[0]}x{size[1]}", _network_table(report, rows)]
    if missing := [row for row in report.rows if row.reason]:
        parts.append("\n".join(["Not run:", "", *(f"- {r.name}: {r.reason}" for r in missing)]))
    if end_to_end:
        parts += ["### From the bytes of a JPEG to maps in metres", _end_to_end(end_to_end)]
    if cold is not None:
        parts += ["### Cold start, fresh processes", cold.as_markdown()]
    parts.append(report.machine.as_markdown())
    return "\n\n".join(parts) + "\n"


def as_json(report: LatencyReport, end_to_end: Sequence[EndToEnd], cold: ColdStart | None) -> str:
    """The same with every single time."""
    content = {
        **asdict(report),
        "end_to_end": [asdict(each) for each in end_to_end],
        "cold_start": None if cold is None else asdict(cold),
    }
    return json.dumps(content, indent=1) + "\n"


def write(
    report: LatencyReport, end_to_end: Sequence[EndToEnd], cold: ColdStart | None, folder: Path
) -> None:
    """Writes ``latency.md`` and ``latency.json``."""
    text = markdown(report, end_to_end, cold)
    (folder / "latency.md").write_text(text, encoding="utf-8")
    (folder / "latency.json").write_text(as_json(report, end_to_end, cold), encoding="utf-8")


def table(columns: Sequence[str], rows: Sequence[Sequence[str]], left: int = 1) -> str:
    """A table in Markdown, the first ``left`` columns flush left, the others flush right."""
    rule = ["---"] * left + ["---:"] * (len(columns) - left)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (columns, rule, *rows))


def _conditions(report: LatencyReport) -> str:
    return (
        f"One frame at a time, {report.threads} thread(s), onnxruntime's spinning "
        f"{report.spinning}; rows of one size timed in turns in random order, {report.trials} "
        "rounds, warmed up apart. Every row takes the same bytes to the same four maps; those "
        "named masks and depths to two of them, those named scale from a coarser head. Accuracy "
        f"is against the exported float32 in onnxruntime on {report.photos}: IoU of ground, mean "
        "relative error of the depth of what is seen. The reference network has random weights; "
        "stock files are without our rewrites of the graph; parts and coarser heads are compared "
        "with float32 of the same."
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
                _times_as_fast(report, row),
                "-" if row.file_bytes is None else f"{row.file_bytes / 1e6:.1f}",
                _figure(accuracy, "ground_iou", ".4f"),
                _figure(accuracy, "visible_depth_abs_rel", ".2%"),
            ]
        )
    if not cells:
        return "No row of this size ran."
    baseline = report.baseline(rows[0].backend.size)
    note = "" if baseline is None else f"\n\nTimes as fast as: {baseline.name}."
    return table(_COLUMNS, cells, left=2) + note


def _figure(accuracy: dict[str, Any] | None, key: str, form: str) -> str:
    return "-" if accuracy is None or accuracy[key] is None else format(accuracy[key], form)


def _times_as_fast(report: LatencyReport, row: LatencyRow) -> str:
    baseline = report.baseline(row.backend.size)
    if baseline is None or baseline.name == row.name:
        return "1"
    found = report.ratios[baseline.name][row.name]
    return f"{found.value:.2f} ({found.low:.2f} to {found.high:.2f})"


def _end_to_end(found: Sequence[EndToEnd]) -> str:
    stages = list(found[0].stages_ms)
    columns = ["model", *(f"{stage} ms" for stage in stages), "all p50", "all p90", "all min", "n"]
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
    return table(columns, rows) + (
        f"\n\nPicture: made up, {width} x {height}, {first.jpeg_bytes / 1e6:.1f} MB. Stages are "
        "medians of their own."
    )
