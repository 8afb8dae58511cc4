"""`fp-bench flicker` on a synthetic clip."""

from typer.testing import CliRunner

from footprints_edge_bench.cli import app


def test_the_command_compares_smoothing_with_single_frames(clip, green_is_ground, tmp_path):
    out = tmp_path / "flicker.md"
    result = CliRunner().invoke(
        app, ["flicker", str(clip), "--model", str(green_is_ground), "-o", str(out)]
    )
    assert result.exit_code == 0, result.output
    assert out.read_text() == result.stdout
    heading, _, title, _, columns, _, *rows = result.stdout.splitlines()
    assert (heading, title) == ("## Flicker", "### walk")
    cells = {row.split("|")[1].strip(): row.split("|")[2:-1] for row in rows}
    assert list(cells) == ["Frame by frame", "Smoothed"]
    # The images are alike, so the model says the same of each of them.
    visible = [each.strip() for each in columns.split("|")][2:-1].index("Visible ground flicker")
    assert {row[visible].strip() for row in cells.values()} == {"0.00 %"}
