"""The path planning benchmark: its ends, its judgement, its table."""

import csv
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from footprints_edge_bench.cli import app
from footprints_edge_bench.ground_truth.base import GroundTruth, LabelledMask
from footprints_edge_bench.navigation.path_planning import judge_route, random_ends

pytest.importorskip("skimage")

SIZE = (20, 30)


def truth_of(ground, visible, valid=None):
    everywhere = np.ones(SIZE, bool)
    return GroundTruth(
        Path("none.jpg"),
        SIZE,
        visible_ground=LabelledMask(visible, everywhere),
        ground=LabelledMask(ground, everywhere if valid is None else valid),
    )


@pytest.fixture
def corridor():
    """Ground in rows 5 to 14; a thing hides its columns from 20 on; rows 0 and 1 are not known."""
    ground = np.zeros(SIZE, bool)
    ground[5:15] = True
    visible = ground.copy()
    visible[:, 20:] = False
    valid = np.ones(SIZE, bool)
    valid[:2] = False
    return truth_of(ground, visible, valid)


def test_paths_go_from_visible_to_hidden_ground(corridor):
    ends = list(random_ends(corridor, 200, np.random.default_rng(0)))
    assert len(ends) == 200
    for (row, column), (to_row, to_column) in ends:
        assert 5 <= row < 15 and column < 20
        assert 5 <= to_row < 15 and to_column >= 20
    assert len(set(ends)) > 150
    assert ends == list(random_ends(corridor, 200, np.random.default_rng(0)))
    assert ends != list(random_ends(corridor, 200, np.random.default_rng(1)))


def test_without_hidden_ground_there_is_no_path(corridor):
    seen = truth_of(corridor.ground.mask, corridor.ground.mask)
    assert list(random_ends(seen, 5, np.random.default_rng(0))) == []
    unknown = GroundTruth(Path("none.jpg"), SIZE, ground=corridor.ground)
    assert list(random_ends(unknown, 5, np.random.default_rng(0))) == []


def test_a_path_fails_where_it_leaves_known_ground(corridor):
    column = np.full(10, 4)
    inside = judge_route(np.stack([np.arange(5, 15), column], 1), corridor, "a", "b")
    assert (inside.failed, inside.collisions) == (False, 0)
    leaving = judge_route(np.stack([np.arange(8, 18), column], 1), corridor, "a", "b")
    assert (leaving.failed, leaving.collisions) == (True, pytest.approx(0.3))
    above = judge_route(np.stack([np.arange(10), column], 1), corridor, "a", "b")
    assert above.collisions == pytest.approx(0.3)  # rows 2 to 4; rows 0 and 1 are not known


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    pytest.importorskip("embreex", reason="scenes are made by ray casting")
    from footprints_edge_models.scenes.make import make_scenes
    from footprints_edge_models.scenes.storage.files import SceneSettings

    folder = tmp_path_factory.mktemp("scenes") / "made"
    make_scenes(folder, SceneSettings("test", 5, (96, 160)), [], 3, 1, lambda _: None)
    return folder


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
