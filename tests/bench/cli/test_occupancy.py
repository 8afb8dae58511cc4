"""`fp-bench occupancy` on synthetic scenes."""

from typer.testing import CliRunner

from footprints_edge_bench.cli import app


def test_the_command_prints_a_row_for_each_model(scenes, green_is_ground):
    result = CliRunner().invoke(
        app, ["occupancy", str(scenes), "--model", "edge", "--model", str(green_is_ground)]
    )
    assert result.exit_code == 0, result.output
    heading, _, columns, _, *rows = result.stdout.splitlines()
    assert heading.startswith("## Occupancy grids: ")
    assert "Walkable cells IoU" in columns
    cells = {row.split("|")[1].strip(): row.split("|")[2].strip("* <u>/") for row in rows[:2]}
    assert list(cells) == ["Ours: edge (int8)", "Ours: green (fp32)"]
    assert all(0 <= float(iou) <= 1 for iou in cells.values())
