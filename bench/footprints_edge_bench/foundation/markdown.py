"""Markdown for reports."""

from collections.abc import Sequence


def markdown_table(columns: Sequence[str], rows: Sequence[Sequence[str]], left: int = 1) -> str:
    """A Markdown table without a final line break.

    Args:
        columns: headings.
        rows: cells, as many in each row as there are columns.
        left: number of columns that are aligned left; the others are aligned right.
    """
    rule = ["---"] * left + ["---:"] * (len(columns) - left)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (columns, rule, *rows))
