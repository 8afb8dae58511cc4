"""What more than one part's tests need: the shared fixtures, a checkpoint of the paper's net."""

import hashlib
import importlib.util
import json
import os
import pickle
import platform
import signal
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from tiny_metadata import TINY

from footprints_edge.cli.doctor import cpu_flags
from footprints_edge.model_files.metadata import ModelMetadata

# Tests of single modules may import onnxruntime before footprints_edge.
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # jobs in the background of a script ignore Ctrl-C, and so would the processes of tests
    signal.signal(signal.SIGINT, signal.default_int_handler)

SHARED = Path(__file__).resolve().parents[1].parent / "shared"

ONE_PROCESS = {
    "tests/runtime/cli/test_infer_on_ray.py": "ray",
    "tests/models/scenes/storage/test_on_ray.py": "ray",
    "tests/models/video_labels/test_on_ray.py": "ray",
    "tests/export/passes/test_pad_as_slices.py": "reference network",
    "tests/export/passes/test_registry.py": "reference network",
    "tests/export/test_partial_networks.py": "reference network",
    "tests/bench/latency/test_benchmark.py": "latency",
}
"""Files that share what is slow to make, or a cluster: no other process waits for it."""


def pytest_configure():
    """A file that was moved would lose its process unseen."""
    checkout = Path(__file__).resolve().parents[1]
    if gone := [name for name in ONE_PROCESS if not (checkout / name).is_file()]:
        raise pytest.UsageError(f"ONE_PROCESS names {gone[0]}, which is not there")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Tests go wherever a process is free, those of ``ONE_PROCESS`` together.

    pytest-xdist 3.8 writes its own groups where pytest 9.2 does not read them.
    """
    from xdist.scheduler import LoadScopeScheduling

    class InGroups(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            return ONE_PROCESS.get(nodeid.split("::")[0], nodeid)

    return InGroups(config, log)


@pytest.fixture(scope="session")
def metadata() -> ModelMetadata:
    """What tiny models say about themselves."""
    return TINY


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of fixtures and photos beside the checkout; skips where it is absent."""
    if not (SHARED / "fixtures" / "reference").is_dir():
        pytest.skip("no ../shared beside this checkout: its fixtures are not part of the clone")
    return SHARED


@pytest.fixture(scope="session")
def exact_int8() -> None:
    """Skips on x86 without VNNI, where products of full-range int8 weights saturate."""
    flags = cpu_flags()
    if platform.machine() in {"x86_64", "AMD64"} and not flags & {"avx512_vnni", "avx_vnni"}:
        pytest.skip("this processor has no VNNI: full-range int8 weights saturate on it")


@pytest.fixture(scope="session")
def reference_layout(shared) -> list[tuple[str, tuple[int, ...]]]:
    """Key and shape of every tensor of a published checkpoint, in order."""
    path = shared / "fixtures" / "reference" / "checkpoint_layout.json"
    return [(key, tuple(shape)) for key, shape in json.loads(path.read_text())]


@pytest.fixture(scope="session")
def reference_checkpoint(shared, reference_layout, tmp_path_factory) -> Path:
    """A checkpoint of the published layout with the weights that the fixtures were made with."""
    torch = pytest.importorskip("torch")
    source = shared / "fixtures" / "reference" / "make_checkpoint.py"
    spec = importlib.util.spec_from_file_location("make_checkpoint", source)
    maker = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(maker)
    path = tmp_path_factory.mktemp("reference") / "model.pth"
    torch.save({key: maker.tensor(key, shape) for key, shape in reference_layout}, path)
    return path


@pytest.fixture(scope="session")
def reference_fixture(shared) -> dict[str, np.ndarray]:
    """A picture, and what the published network makes of it with those weights."""
    with np.load(shared / "fixtures" / "reference" / "network_96x128.npz") as arrays:
        return dict(arrays)


@pytest.fixture(scope="session")
def once(tmp_path_factory):
    """The function that makes something in a folder of its own, once for all test processes.

    What ``make(folder)`` returns is pickled: the processes that come later get it from there.
    """
    filelock = pytest.importorskip("filelock")
    base = tmp_path_factory.getbasetemp()
    if os.environ.get("PYTEST_XDIST_WORKER"):
        base = base.parent  # the folder of all processes

    def give(name, make):
        folder, result = base / f"once-{name}", base / f"once-{name}.pickle"
        with filelock.FileLock(base / f"once-{name}.lock"):
            if not result.is_file():
                folder.mkdir(exist_ok=True)
                result.write_bytes(pickle.dumps(make(folder)))
        return pickle.loads(result.read_bytes())

    return give


@pytest.fixture(scope="session")
def graphs_once(once):
    """Makes each graph that torch's exporter gives once for all test processes.

    It is known by architecture, part, weights and size. A graph takes some 12 seconds.
    """
    import onnx
    import onnx_ir as ir

    from footprints_edge_export.graph import torch_export
    from footprints_edge_export.graph.editing import to_proto

    made, traced = {}, torch_export.traced

    def remembered(network, size):
        part = (getattr(network, "outputs", None), getattr(network, "scale", None))
        weights = sum(tensor.double().sum().item() for tensor in network.state_dict().values())
        key = (type(network).__name__, part, weights, size)
        if key not in made:
            name = f"graph-{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}"

            def make(_folder):
                return to_proto(traced(network, size)).SerializeToString()

            made[key] = ir.from_proto(onnx.load_from_string(once(name, make)))
        return made[key].clone()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(torch_export, "traced", remembered)
        yield
