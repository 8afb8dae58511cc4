"""onnxruntime, as the runtime package runs it or with other spinning."""

from functools import partial
from pathlib import Path

import numpy as np

from footprints_edge.engines.onnxruntime_engine import OnnxRuntimeEngine
from footprints_edge.foundation.types import Floats, Rgb
from footprints_edge_bench.engines.backend import (
    Backend,
    BackendSetting,
    LoadedBackend,
    Spinning,
    describe_precisions,
)
from footprints_edge_bench.engines.ort_profile import convolutions, profile


def open_with(backend: Backend, setting: BackendSetting) -> LoadedBackend:
    """Loads a backend; its precision is that of its convolutions in the profiler."""
    path = setting.cache.onnx(backend.network, backend.size, backend.precision)
    if setting.spinning is Spinning.SHIPPED:
        run = OnnxRuntimeEngine(path, threads=setting.threads).run
    else:
        run = partial(_run, _session(path, setting.threads, setting.spinning))
    noise = np.random.default_rng(0).integers(0, 256, (1, *backend.size, 3), np.uint8)
    operators = profile(path, {"image": noise}, threads=setting.threads, frames=1)
    return LoadedBackend(run, describe_precisions(convolutions(operators)), path.stat().st_size)


def _session(path: Path, threads: int, spinning: Spinning) -> object:
    import onnxruntime as ort

    options = ort.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.log_severity_level = 4
    key = "session.intra_op.allow_spinning"
    options.add_session_config_entry(key, str(int(spinning is Spinning.ON)))
    return ort.InferenceSession(path, options, providers=["CPUExecutionProvider"])


def _run(session: object, image: Rgb) -> Floats:
    maps: Floats = session.run(["maps"], {"image": image})[0]  # type: ignore[attr-defined]
    return maps
