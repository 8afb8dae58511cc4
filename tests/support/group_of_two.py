"""A training run of three steps, alone or as one of two processes, which import it anew."""

import os

import numpy as np
import torch

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.sample import NO, YES, Sample
from footprints_edge_models.training.recipe import Recipe
from footprints_edge_models.training.schedule import ScheduleStage
from footprints_edge_models.training.trainer import train


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
