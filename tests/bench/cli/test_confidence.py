"""`fp-bench confidence` on synthetic scenes."""

import numpy as np
from PIL import Image
from typer.testing import CliRunner

from footprints_edge_bench.cli import app


def test_it_scores_scenes_and_pictures_without_ground(scenes, tmp_path):
    walls = tmp_path / "walls"
    walls.mkdir()
    for name, grey in (("a", 90), ("b", 200)):
        Image.fromarray(np.full((96, 128, 3), grey, np.uint8)).save(walls / f"{name}.png")
    diagram = tmp_path / "diagram.png"
    options = ("--without", str(walls), "-o", str(diagram))
    result = CliRunner().invoke(app, ["confidence", str(scenes), *options])
    assert result.exit_code == 0, result.output
    assert "## Confidence: ground" in result.stdout
    row = next(line for line in result.stdout.splitlines() if line.startswith("| walls"))
    assert [each.strip() for each in row.split("|")[1:4]] == ["walls", "without ground", "1"]
    assert diagram.is_file()
