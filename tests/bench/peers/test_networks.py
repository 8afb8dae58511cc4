"""The peers' networks: as large as the published ones, and the same in both engines."""

import numpy as np
import pytest

from footprints_edge_bench.peers.mousavian import CropsShape, mousavian
from footprints_edge_bench.peers.run_network import run_in
from footprints_edge_bench.peers.sscnet import SscNetShape, sscnet
from footprints_edge_bench.peers.votenet import Abstraction, VoteNetShape, votenet

torch = pytest.importorskip("torch")

TINY = {
    "votenet": lambda: votenet(
        VoteNetShape(
            200,
            tuple(Abstraction(count, 0.6, 4, (4, 4, 8)) for count in (64, 32, 16, 8)),
            Abstraction(8, 0.9, 4, (4, 4, 4)),
            8,
        ),
        (24, 32),
    ),
    "mousavian": lambda: mousavian(
        CropsShape(64, (1, 1, 1, 1, 1), 4, 32, ((1, 4), (1, 4), (2, 8)), (8, 16)), (60, 90)
    ),
    "sscnet": lambda: sscnet(SscNetShape((24, 16, 24), 0.2, (4, 4, 8)), (24, 32)),
}


@pytest.mark.parametrize("name", TINY)
def test_both_engines_give_the_same(name):
    peer = TINY[name]()
    networks, prepared = peer.networks(), peer.prepare()
    for network in networks.values():  # statistics that are not those of an untrained layer
        for module in network.module.modules():
            if hasattr(module, "running_mean"):
                module.running_mean.uniform_(-0.2, 0.2)
    found = [
        peer.infer({key: run_in(engine, each, 1) for key, each in networks.items()}, prepared)
        for engine in ("torch", "onnxruntime")
    ]
    assert len(found[0]) == len(found[1]) > 0
    for ours, theirs in zip(*found, strict=True):
        assert ours.shape == theirs.shape
        assert np.isfinite(ours).all()
        assert ours == pytest.approx(theirs, abs=1e-4)


@pytest.mark.parametrize(
    ("make", "name", "parameters"),
    [
        (mousavian, "detector", 61_949_149),  # YOLOv3 for 80 classes
        (mousavian, "crops", 20_024_384 + 26_088_457),  # VGG-19's convolutions, and the branches
    ],
)
def test_a_network_has_the_parameters_of_the_published_one(make, name, parameters):
    with torch.device("meta"):
        module = make().networks()[name].module
    assert sum(each.numel() for each in module.parameters()) == parameters


def on_meta(arrays):
    return [torch.empty(each.shape, dtype=getattr(torch, each.dtype.name)) for each in arrays]


def test_votes_and_boxes_have_the_papers_numbers():
    with torch.device("meta"):
        networks = votenet().networks()
        examples = {
            name: [
                torch.empty(each.shape, dtype=torch.as_tensor(each).dtype)
                for each in network.examples
            ]
            for name, network in networks.items()
        }
        moves, features = networks["votes"].module(*examples["votes"])
        (boxes,) = networks["proposals"].module(*examples["proposals"])
    assert moves.shape == (1, 3, 1024)
    assert features.shape == (1, 256, 1024)
    assert boxes.shape == (1, 79, 256)


def test_voxels_come_out_at_a_quarter_of_the_sides():
    with torch.device("meta"):
        (scores,) = sscnet().networks()["voxels"].module(torch.empty(1, 1, 240, 144, 240))
    assert scores.shape == (1, 12, 60, 36, 60)
