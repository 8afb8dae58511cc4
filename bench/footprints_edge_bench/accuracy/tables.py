"""Scores as Markdown tables, in the form of the paper's Tables 1 to 4."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from footprints_edge_bench.accuracy.baselines import NOTHING
from footprints_edge_bench.accuracy.summary import ScoreSummary

Rows = Mapping[str, Mapping[str, ScoreSummary]]
"""Summaries by row and part."""


@dataclass(frozen=True)
class Column:
    """A column of scores.

    Attributes:
        heading: heading of the column.
        part: attribute of ``MethodScores``.
        measure: attribute of that part.
        pooled: whether to take the score over all pixels instead of the mean over images.
        lowest_is_best: whether lower is better, as for errors.
    """

    heading: str
    part: str
    measure: str
    pooled: bool = False
    lowest_is_best: bool = False

    def of(self, parts: Mapping[str, ScoreSummary]) -> float:
        """The score of a row; NaN where it has none."""
        summary = parts.get(self.part)
        if summary is None:
            return math.nan
        return (summary.pooled if self.pooled else summary.means)[self.measure]


def _depth_columns(part: str) -> tuple[Column, ...]:
    return (
        Column("a1", part, "a1"),
        Column("RMSE", part, "rmse", lowest_is_best=True),
        Column("Abs. rel.", part, "abs_rel", lowest_is_best=True),
        Column("Sq. rel.", part, "sq_rel", lowest_is_best=True),
    )


TABLES: dict[str, tuple[Column, ...]] = {
    "Ground, seen or hidden (S*)": (
        Column("Freespace IoU", "freespace", "iou"),
        Column("Freespace F1", "freespace", "f1"),
        Column("Footprint IoU", "footprint", "iou"),
        Column("Footprint F1", "footprint", "f1"),
        Column("Right near borders", "ground_border", "recall"),
    ),
    "Behind things (S*)": (
        Column("AUC, hidden free against footprint", "ranking", "auc", pooled=True),
        Column("Hidden ground found", "hidden_ground", "recall"),
        Column("Non-ground called ground", "outside", "recall", lowest_is_best=True),
    ),
    "Hidden depth (D*)": _depth_columns("ground_depth"),
    "Visible ground (S)": (
        Column("IoU", "visible_ground", "iou"),
        Column("F1", "visible_ground", "f1"),
        Column("Precision", "visible_ground", "precision"),
        Column("Recall", "visible_ground", "recall"),
        Column("Right near borders", "visible_border", "recall"),
    ),
    "Visible depth (D)": _depth_columns("visible_depth"),
    "All pixels pooled": (
        Column("Freespace IoU", "freespace", "iou", pooled=True),
        Column("Footprint IoU", "footprint", "iou", pooled=True),
        Column("Visible ground IoU", "visible_ground", "iou", pooled=True),
    ),
}
"""Columns by title. The first table is the paper's Tables 1 to 3, the second its Table 4."""


def tables(rows: Rows) -> str:
    """Every table that is not empty.

    The best score of a column is bold, the second best underlined. Rows that use the ground truth
    (‡) do not compete.
    """
    parts = []
    for title, columns in TABLES.items():
        present = {
            name: [column.of(summaries) for column in columns]
            for name, summaries in rows.items()
            if any(column.part in summaries for column in columns)
        }
        if any(not math.isnan(value) for values in present.values() for value in values):
            parts.append(f"#### {title}\n\n{table(present, columns, _labels(rows, columns))}")
    return "\n\n".join(parts)


def _labels(rows: Rows, columns: tuple[Column, ...]) -> Callable[[str], str]:
    """Labels of rows, with their number of images where it differs from the table's."""

    def images(name: str) -> int:
        return max((rows[name][c.part].images for c in columns if c.part in rows[name]), default=0)

    most = max(images(name) for name in rows)

    def label(name: str) -> str:
        count = images(name)
        return name if count == most else f"{name} ({count} of {most} images)"

    return label


def table(
    rows: Mapping[str, list[float]], columns: tuple[Column, ...], label: Callable[[str], str]
) -> str:
    """One table.

    Args:
        rows: scores by row, in the order of the columns; NaN where there is none.
        columns: columns; those without any score are left out.
        label: gives the label of a row.
    """
    kept = [i for i in range(len(columns)) if any(not math.isnan(v[i]) for v in rows.values())]
    lines = [
        "| | " + " | ".join(columns[i].heading for i in kept) + " |",
        "| --- |" + " ---: |" * len(kept),
    ]
    ranks = {i: _ranks(rows, i, columns[i]) for i in kept}
    for name, values in rows.items():
        cells = (_cell(values[i], ranks[i]) for i in kept)
        lines.append(f"| {label(name)} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _ranks(rows: Mapping[str, list[float]], index: int, column: Column) -> list[str]:
    """The best and the second best score of a column, as printed."""
    competing = {
        f"{values[index]:.3f}"
        for name, values in rows.items()
        if not name.endswith("‡") and not math.isnan(values[index])
    }
    return sorted(competing, key=float, reverse=not column.lowest_is_best)[:2]


def _cell(value: float, ranks: list[str]) -> str:
    if math.isnan(value):
        return ""
    text = f"{value:.3f}"
    if text in ranks and len(ranks) == 2:
        return f"**{text}**" if text == ranks[0] else f"<u>{text}</u>"
    return text


def missing_rows(rows: Rows, needs: Mapping[str, str]) -> list[str]:
    """For each row that could not be computed, a note with its missing input."""
    if NOTHING not in rows:
        return [
            "Every baseline needs ground truth of hidden ground, which this dataset does not have."
        ]
    return [f"{name.rstrip(' †‡')}: {need}." for name, need in needs.items() if name not in rows]
