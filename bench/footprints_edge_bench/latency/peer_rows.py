"""The methods of the paper's speed table on this machine: networks of their shape, in turns."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from footprints_edge.foundation.install_hint import install_hint
from footprints_edge_bench.latency.timing import measure
from footprints_edge_bench.peers.mousavian import mousavian
from footprints_edge_bench.peers.peer import Peer
from footprints_edge_bench.peers.run_network import ENGINES, run_in
from footprints_edge_bench.peers.sscnet import sscnet
from footprints_edge_bench.peers.votenet import votenet

PEERS: tuple[Callable[[], Peer], ...] = (sscnet, votenet, mousavian)
"""The peers, in the order of the paper's table."""


@dataclass(frozen=True)
class PeerRow:
    """A peer in an engine, measured on this machine.

    Attributes:
        method: its row of the paper's table.
        engine: what ran its networks, float32 with random weights.
        leaves_out: what the method does beyond what was timed.
        reason: why it did not run; None if it did.
        preprocessing_s: median time from the raw frame to the network's input.
        inference_s: median time from there to the network's outputs.
    """

    method: str
    engine: str
    leaves_out: str
    reason: str | None = None
    preprocessing_s: float | None = None
    inference_s: float | None = None


def time_peers(
    peers: Sequence[Callable[[], Peer]],
    threads: int,
    trials: int,
    progress: Callable[[str], None] | None = None,
) -> list[PeerRow]:
    """Times peers one after the other, the engines of each in turns.

    Args:
        peers: make what is timed; one is in memory at a time.
        threads: threads for one frame.
        trials: timed frames of each.
        progress: called with the name of a row after each of its trials.
    """
    return [row for make in peers for row in _time_peer(make(), threads, trials, progress)]


def _time_peer(
    peer: Peer, threads: int, trials: int, progress: Callable[[str], None] | None
) -> list[PeerRow]:
    rows = [PeerRow(peer.method, engine, peer.leaves_out) for engine in ENGINES]
    try:
        networks = peer.networks()
        prepared = peer.prepare()
        runs = {
            engine: {name: run_in(engine, each, threads) for name, each in networks.items()}
            for engine in ENGINES
        }
    except ModuleNotFoundError as error:
        reason = f"needs the package {error.name}; {install_hint('bench')}"
        return [PeerRow(row.method, row.engine, row.leaves_out, reason) for row in rows]
    timed = measure(
        {
            "preprocessing": peer.prepare,
            **{engine: partial(peer.infer, runs[engine], prepared) for engine in ENGINES},
        },
        trials,
        warm_up=1,
        settle_ms=0,  # a frame takes longer than threads of the one before it spin
        progress=progress and (lambda name: progress(f"{peer.method} {name}")),
    )
    preparing_s, *inferring_s = (
        timed[name].summary().p50_ms / 1000 for name in ("preprocessing", *ENGINES)
    )
    return [
        PeerRow(row.method, row.engine, row.leaves_out, None, preparing_s, inference_s)
        for row, inference_s in zip(rows, inferring_s, strict=True)
    ]
