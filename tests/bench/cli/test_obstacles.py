"""`fp-bench obstacles` on synthetic scenes."""

from typer.testing import CliRunner

from footprints_edge_bench.cli import app


def test_the_command_prints_a_row_for_each_rule_for_each_model(scenes):
    result = CliRunner().invoke(app, ["obstacles", str(scenes)])
    assert result.exit_code == 0, result.output
    heading, scores, by_range = result.stdout.strip().split("\n\n")
    columns, _, *rows = scores.splitlines()
    assert heading.startswith("## Nearest obstacle, 0.15 to 1.2 m high: ")
    assert "too far" in columns
    names = [row.split("|")[1].strip() for row in rows]
    suffixes = ("", ", height, pitch and roll known", ", walkable behind things")
    assert names == ["Ours: edge (int8)" + suffix for suffix in suffixes]
    shares = [float(row.split("|")[2]) for row in by_range.splitlines()[2:]]
    assert shares
    assert all(0 <= share <= 1 for share in shares)
