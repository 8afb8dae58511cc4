"""Timing of the peers."""

import sys

import pytest

from footprints_edge_bench.latency.peer_rows import time_peers
from footprints_edge_bench.peers.peer import Peer, PeerNetwork
from footprints_edge_bench.peers.sscnet import SscNetShape, sscnet


def tiny():
    return sscnet(SscNetShape((24, 16, 24), 0.2, (4, 4, 8)), (24, 32))


def test_a_peer_has_a_row_for_each_engine():
    pytest.importorskip("torch")
    seen = []
    rows = time_peers([tiny], 1, 2, seen.append)
    assert [row.engine for row in rows] == ["torch", "onnxruntime"]
    assert all(row.reason is None and row.inference_s > 0 for row in rows)
    assert rows[0].preprocessing_s == rows[1].preprocessing_s > 0
    assert seen.count("Voxels (SSCNet) preprocessing") == 2


def test_without_a_package_the_rows_say_which(monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    rows = time_peers([tiny], 1, 2)
    assert ["torch" in row.reason for row in rows] == [True, True]


def test_a_peer_runs_what_it_was_given():
    """Not one network twice: the rows would be equal for a wrong reason."""
    torch = pytest.importorskip("torch")
    import numpy as np

    class Twice(torch.nn.Module):
        def forward(self, x):
            return (2 * x,)

    found = []
    network = PeerNetwork(Twice().eval(), (np.ones((1, 2), np.float32),))
    peer = Peer(
        "Voxels (SSCNet)",
        lambda: {"a": network},
        lambda: np.full((1, 2), 3, np.float32),
        lambda runs, x: found.append(runs["a"](x)[0].tolist()),
        "nothing",
    )
    time_peers([lambda: peer], 1, 1)
    assert found == [[[6.0, 6.0]]] * 4  # a warm-up and a timed frame in each engine
