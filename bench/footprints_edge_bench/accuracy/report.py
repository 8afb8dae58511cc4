"""The files that an accuracy benchmark writes."""

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from footprints_edge_bench.accuracy.baselines import BASELINES, BOXES, ORACLE, VOXELS
from footprints_edge_bench.accuracy.benchmark import Benchmark
from footprints_edge_bench.accuracy.failure_cases import failure_cases
from footprints_edge_bench.accuracy.failure_sheet import draw_examples
from footprints_edge_bench.accuracy.results import Results
from footprints_edge_bench.accuracy.summary import MEASURES, ScoreSummary, summarise
from footprints_edge_bench.accuracy.tables import missing_rows, tables

NEEDS = {
    BOXES: "needs oriented boxes, --boxes FILE",
    VOXELS: "needs the scene in voxels, --voxels FOLDER",
    ORACLE: "needs ground truth of visible ground and its depth",
}
"""Inputs of the rows that few datasets can have."""

_OPTIONS = ("frames", "held_out", "every", "walkable", "void")


def write_reports(
    benchmark: Benchmark, results: Results, failures: Mapping[str, str], out: Path
) -> str:
    """Writes ``accuracy.md``, ``accuracy.json``, ``per-image.csv`` and ``worst.png``.

    Args:
        benchmark: what was evaluated.
        results: its scores.
        failures: images that failed, with the reason.
        out: an existing folder.

    Returns:
        The Markdown.
    """
    order = [*BASELINES, *benchmark.rows()]
    groups = _groups(benchmark, results, order)
    settings = benchmark.settings()
    sections = [group.as_markdown() for group in groups]
    markdown = "\n\n".join(["## Accuracy", *sections, _provenance(settings, failures)]) + "\n"
    report = {
        "settings": settings,
        "skipped": dict(failures),
        "summaries": {group.title: group.as_json() for group in groups},
    }
    (out / "accuracy.md").write_text(markdown, encoding="utf-8")
    (out / "accuracy.json").write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
    (out / "per-image.csv").write_text(_csv(benchmark, results, order), encoding="utf-8")
    examples = failure_cases(benchmark, results)
    if examples:
        draw_examples(examples).save(out / "worst.png")
    return markdown


@dataclass(frozen=True)
class _Group:
    """The summaries of a dataset, or of all of them together.

    Attributes:
        title: heading of its section.
        scored: number of images with scores.
        skipped: number of images without.
        rows: summaries by row and part, in the order of the tables.
    """

    title: str
    scored: int
    skipped: int
    rows: Mapping[str, Mapping[str, ScoreSummary]]

    def as_markdown(self) -> str:
        counts = f"{self.scored} images"
        if self.skipped:
            counts += f", {self.skipped} skipped"
        section = [f"### {self.title}: {counts}"]
        if self.rows:
            notes = missing_rows(self.rows, NEEDS)
            section.append(tables(self.rows))
            section.append("\n".join(["Left out:", "", *(f"- {note}" for note in notes)]))
        return "\n\n".join(section)

    def as_json(self) -> dict[str, Any]:
        return {
            row: {part: summary.as_json() for part, summary in parts.items()}
            for row, parts in self.rows.items()
        }


def _groups(benchmark: Benchmark, results: Results, order: Sequence[str]) -> list[_Group]:
    names_of = {each.name: [item.name for item in each.items] for each in benchmark.datasets}
    if len(names_of) > 1:
        names_of = {"All images": [item.name for item in benchmark.items()], **names_of}
    groups = []
    for title, names in names_of.items():
        done = [results.images[name] for name in names if name in results.images]
        found = summarise(done)
        rows = {row: found[row] for row in order if row in found}
        groups.append(_Group(title, len(done), len(names) - len(done), rows))
    return groups


def _provenance(settings: Mapping[str, Any], failures: Mapping[str, str]) -> str:
    lines = [
        "### Provenance",
        "",
        "Scores are means over images; images without ground-truth pixels are left out. The best "
        "score of a column is bold, the second best underlined. † uses measured depth or other "
        "sensors, ‡ uses the ground truth. Baselines start from the first model's visible ground "
        "and depth.",
        "",
        f"- footprints-edge {settings['version']}, {settings['runtime']}",
        *(f"- {row}: sha256 {sha256}" for row, sha256 in settings["models"].items()),
        *(f"- {name}: {kind}" for name, kind in settings["datasets"].items()),
        f"- options: {json.dumps({k: settings[k] for k in sorted(settings) if k in _OPTIONS})}",
        *(f"- skipped {name}: {reason}" for name, reason in failures.items()),
    ]
    return "\n".join(lines)


def _csv(benchmark: Benchmark, results: Results, order: Sequence[str]) -> str:
    """One line per image and row; empty cells where there is no score."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    columns = [(part, measure) for part, measures in MEASURES.items() for measure in measures]
    writer.writerow(["image", "method", *(f"{part}_{measure}" for part, measure in columns)])
    for item in benchmark.items():
        scores = results.images.get(item.name, {})
        for row in order:
            if row in scores:
                writer.writerow([item.name, row, *(scores[row].value(*c) for c in columns)])
    return file.getvalue()
