"""Runs a peer's network: in PyTorch, or exported as it is in onnxruntime."""

import tempfile
from pathlib import Path

from footprints_edge_bench.peers.peer import Arrays, PeerNetwork, Run

ENGINES = ("torch", "onnxruntime")


def run_in(engine: str, network: PeerNetwork, threads: int) -> Run:
    """A function that runs a network, float32.

    Args:
        engine: one of `ENGINES`.
        network: the network.
        threads: threads for one frame.
    """
    return {"torch": _in_torch, "onnxruntime": _in_onnxruntime}[engine](network, threads)


def _in_torch(network: PeerNetwork, threads: int) -> Run:
    import torch

    torch.set_num_threads(threads)

    def run(*arrays: object) -> Arrays:
        with torch.inference_mode():
            found = network.module(*(torch.as_tensor(array) for array in arrays))
        return tuple(each.numpy() for each in found)

    return run


def _in_onnxruntime(network: PeerNetwork, threads: int) -> Run:
    import onnxruntime as ort
    import torch

    options = ort.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.log_severity_level = 4
    options.add_session_config_entry("session.force_spinning_stop", "1")  # as we run ours
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "peer.onnx")
        examples = tuple(torch.as_tensor(array) for array in network.examples)
        torch.onnx.export(network.module, examples, path, dynamo=True, verbose=False)
        session = ort.InferenceSession(path, options, providers=["CPUExecutionProvider"])
    names = [each.name for each in session.get_inputs()]

    def run(*arrays: object) -> Arrays:
        return tuple(session.run(None, dict(zip(names, arrays, strict=True))))

    return run
