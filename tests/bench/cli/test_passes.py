"""`fp-bench passes` on trained weights."""

from pathlib import Path

import pytest
from PIL import Image
from typer.testing import CliRunner

from footprints_edge_bench.cli import app


@pytest.mark.usefixtures("exact_int8", "graphs_once")
def test_what_changes_in_the_maps_of_trained_weights(tmp_path):
    """The bundled weights: int8 is near float32, and the passes are nearer to int8 than that."""
    weights = Path(__file__).parents[3] / "models" / "weights" / "edge.pt"
    photo = Image.open(Path(__file__).parents[3] / "examples" / "room.jpg")
    for i in range(10):
        left = 40 * i
        photo.crop((left, 0, left + 800, 500)).resize((240, 150)).save(tmp_path / f"{i}.png")
    command = ["passes", "--network", "edge", "--size", "128x192", "--threads", "1"]
    command += ["--checkpoint", str(weights), "--photos", str(tmp_path)]
    found = CliRunner().invoke(app, command)
    assert found.exit_code == 0, found.output
    header, _, *lines = found.stdout.splitlines()
    assert header.startswith("| 2 photos |")  # of ten, one in five is judged by
    cells = {line.split("|")[1].strip(): line.split("|")[2:-1] for line in lines}
    assert list(cells) == [
        "int8, as exported against float32",
        "int8, all passes against float32",
        "int8, all passes against int8, as exported",
    ]
    ious = {name: min(map(float, values[:2])) for name, values in cells.items()}
    assert ious["int8, all passes against int8, as exported"] > 0.998
    assert 0.7 < ious["int8, all passes against float32"] < 0.998

    found = CliRunner().invoke(app, command[:-2])
    assert found.exit_code == 2 and "--photos" in found.stderr
