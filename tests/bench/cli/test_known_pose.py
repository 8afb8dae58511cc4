"""`fp-bench known-pose` on synthetic scenes."""

import pytest
from typer.testing import CliRunner

from footprints_edge_bench.cli import app


def test_everything_known_is_exact_where_the_ground_is_flat(scenes):
    result = CliRunner().invoke(app, ["known-pose", str(scenes)])
    assert result.exit_code == 0, result.output
    rows = [line.split("|")[1:5] for line in result.stdout.splitlines() if line.startswith("| ")]
    scores = {name.strip(): score.strip() for name, score, _, _ in rows[1:]}
    distances = {name.strip(): distance.strip() for name, _, _, distance in rows[1:]}
    assert list(scores)[-4:] == ["nothing", "height", "pitch and roll", "height, pitch and roll"]
    if scores["nothing"] != "-":
        assert float(scores["height, pitch and roll"]) > 0.97
        assert float(distances["height, pitch and roll"]) == pytest.approx(1, abs=0.02)
