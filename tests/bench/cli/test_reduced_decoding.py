"""`fp-bench reduced-decoding` on the example photo."""

from pathlib import Path

from typer.testing import CliRunner

from footprints_edge_bench.cli import app

ROOM = Path(__file__).resolve().parents[3] / "examples" / "room.jpg"


def test_the_command_prints_two_rows_for_a_photo():
    result = CliRunner().invoke(app, ["reduced-decoding", str(ROOM)])
    assert result.exit_code == 0, result.output
    header, _, decoding, jpeg = result.stdout.splitlines()
    assert header.startswith("| photo | effect of | visible ground IoU |")
    assert decoding.startswith("| room.jpg, ") and "| decoding at " in decoding
    assert "| the JPEG, quality 92 |" in jpeg
    ious = [float(row.split("|")[3]) for row in (decoding, jpeg)]
    assert all(0.9 < iou <= 1 for iou in ious)


def test_a_photo_that_is_missing_is_named(tmp_path):
    result = CliRunner().invoke(app, ["reduced-decoding", str(tmp_path / "none.jpg")])
    assert result.exit_code == 2
    assert "none.jpg" in result.stderr
