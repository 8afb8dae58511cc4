"""`fp-bench planning` on synthetic scenes."""

import csv

import numpy as np
import pytest
from typer.testing import CliRunner

from footprints_edge_bench.cli import app

pytest.importorskip("skimage")


def plan(scenes, model, out, *options):
    result = CliRunner().invoke(
        app, ["planning", str(scenes), "--model", str(model), "-o", str(out), *options]
    )
    assert result.exit_code == 0, result.output
    return result.stdout


def test_the_command_prints_the_papers_table_again_and_again(scenes, green_is_ground, tmp_path):
    said = plan(scenes, green_is_ground, tmp_path / "a", "--paths", "4")
    assert said == (tmp_path / "a" / "planning.md").read_text()
    assert said == plan(scenes, green_is_ground, tmp_path / "b", "--paths", "4")
    rows = {line.split(" | ")[0].removeprefix("| ") for line in said.splitlines() if "|" in line}
    assert {
        "Convex hull",
        "3D bounding boxes †",
        "Visible ground",
        "Nothing traversable",
        "Ground truth ‡",
    } <= rows
    with (tmp_path / "a" / "planning.csv").open() as file:
        paths = list(csv.DictReader(file))
    of = {}
    for path in paths:
        of.setdefault(path["method"], []).append(float(path["collisions"]))
        assert (path["failed"] == "1") == (float(path["collisions"]) > 0)
    assert len({len(collisions) for collisions in of.values()}) == 1
    best = np.mean(of.pop("Ground truth ‡"))
    assert all(best <= np.mean(collisions) for collisions in of.values())
    other = plan(scenes, green_is_ground, tmp_path / "c", "--paths", "4", "--seed", "1")
    assert other != said
