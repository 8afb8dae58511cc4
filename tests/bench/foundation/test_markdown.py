"""Markdown tables."""

from footprints_edge_bench.foundation.markdown import markdown_table


def test_a_table_aligns_its_columns():
    table = markdown_table(["a", "b", "c"], [["x", "y", "1"], ["z", "", "2"]], left=2)
    assert table == "| a | b | c |\n| --- | --- | ---: |\n| x | y | 1 |\n| z |  | 2 |"
