"""A timed run goes on: without scenes, without memory, after losses that are no numbers."""

import csv
import time

import pytest
import torch

from footprints_edge_models.asset_files.credit_files import write_credits_file
from footprints_edge_models.networks.checkpoint import load_weights, read_checkpoint
from footprints_edge_models.networks.edge import EdgeNetwork
from footprints_edge_models.training.gpu_kit.kit_settings import (
    INITIAL_WEIGHTS,
    SETTINGS,
    SHARD,
    KitSettings,
)
from footprints_edge_models.training.gpu_kit.stored_view import stored_view
from footprints_edge_models.training.gpu_kit.timed_run import RunSize, _Clock, _TimedRun
from footprints_edge_models.training.gpu_kit.view_shard import ShardView, write_shard
from footprints_edge_models.training.run_files import save_weights

CPU = torch.device("cpu")


class NoScenes:
    """A stream that makes nothing."""

    scenes = failed = waiting = 0
    alive = False

    def ready(self, _):
        return []


@pytest.fixture
def run(sample, tmp_path):
    """A run of four seconds on two photos, one of them held out."""
    kit, out = tmp_path / "kit", tmp_path / "out"
    kit.mkdir()
    out.mkdir()
    settings = KitSettings((64, 96), {"photos": 1.0}, 0, {"dice": 0.1})
    (kit / SETTINGS).write_text(settings.to_json())
    torch.manual_seed(0)
    save_weights(EdgeNetwork(), 300.0, kit / INITIAL_WEIGHTS)
    write_credits_file(kit, [])
    views = [stored_view(sample(seed), 9000) for seed in (0, 1)]
    splits = zip(views, ("train", "held out"), strict=True)
    write_shard(kit / SHARD, [ShardView(view, "photos", split) for view, split in splits])
    clock = _Clock(time.monotonic(), 4.0)
    return _TimedRun(kit, out, settings, RunSize.toy(), 2, CPU, NoScenes(), clock)


def rows(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def test_a_run_without_scenes_learns_from_what_is_there(run, tmp_path):
    run.train()
    weights = read_checkpoint(run.finish())
    load_weights(EdgeNetwork(), weights, "weights")
    assert float(weights["canonical_focal_px"]) == 300
    assert {"visible_ground", "ground", "dice", "loss"} < set(rows(tmp_path / "out/train.csv")[0])
    assert [row["dataset"] for row in rows(tmp_path / "out/validation.csv")][-1] == "photos"


def test_batches_are_halved_where_memory_runs_out(run, monkeypatch):
    step, calls = run._learner.step, []

    def short_of_memory(batch, rate):
        calls.append(len(batch[0]))
        if len(batch[0]) > 1:
            raise torch.OutOfMemoryError("no memory")
        return step(batch, rate)

    monkeypatch.setattr(run._learner, "step", short_of_memory)
    assert not run._learn(0.0)
    assert run._learn(0.0)
    assert calls == [2, 1]


def test_after_losses_that_are_no_numbers_the_good_weights_come_back(run, tmp_path):
    run._keep()
    good = run._learner.network.head.weight.detach().clone()
    with torch.no_grad():
        run._learner.network.head.weight.fill_(torch.nan)
    assert run._learn(0.0)
    run._read()
    assert torch.equal(run._learner.network.head.weight, good)
    assert run._caution == 0.5
    assert not (tmp_path / "out/train.csv").exists()
    saved = (tmp_path / "out/weights.pt").read_bytes()
    with torch.no_grad():
        run._learner.average.head.weight.fill_(torch.nan)
    run._keep()
    assert (tmp_path / "out/weights.pt").read_bytes() == saved


def test_the_faster_layout_is_chosen_and_the_weights_stay(run, monkeypatch, caplog):
    caplog.set_level("INFO")
    monkeypatch.setattr(torch.cuda, "synchronize", lambda _: None)
    before = run._learner.network.head.weight.detach().clone()
    run._warm_up()
    assert torch.equal(run._learner.network.head.weight, before)
    assert "channels_last" in caplog.text
    assert run._learn(0.0)


def test_what_is_said_about_a_run_cannot_end_it(run, caplog):
    def broken():
        raise OSError("the disk is full")

    run._guarded(broken)
    assert "the disk is full" in caplog.text
