"""Roofline: how close each network comes to the machine's peak, operator by operator.

The peak is the rate of onnxruntime's own matrix product on this machine, at a size that suits it.
No network can run faster than its multiply-accumulates at that rate, unless an algorithm needs
fewer of them.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from footprints_edge.engines.onnxruntime_engine import OnnxRuntimeEngine
from footprints_edge_bench.engines.backend import Backend
from footprints_edge_bench.engines.ort_profile import Operator, profile
from footprints_edge_bench.foundation.markdown import markdown_table
from footprints_edge_bench.latency.machine import Machine
from footprints_edge_bench.latency.timing import measure
from footprints_edge_bench.model_files.model_cache import ModelCache

SIDE = 1536
"""Side of the square matrices; their product takes 3.6 billion multiply-accumulates."""

PEAK_TRIALS = 30
"""Minimum number of timed products; the peak is the fastest of them."""

_NAMES = {True: "int8", False: "fp32"}


@dataclass(frozen=True)
class OperatorKind:
    """All operators of one kind in a network.

    Attributes:
        name: operator type and number type, such as ``QLinearConv uint8``.
        count: number of operators.
        ms: time of all of them per frame.
        macs: multiply-accumulates of all of them per frame, as executed; 0 if they have none.
        of_peak: their rate as a share of the peak at their precision; None if they have no macs.
    """

    name: str
    count: int
    ms: float
    macs: int
    of_peak: float | None


@dataclass(frozen=True)
class NetworkRoofline:
    """A network against the peak.

    Attributes:
        name: network, size and precision.
        ms: fastest frame, without the profiler.
        least_ms: time of its multiply-accumulates at the peaks of their precisions.
        profiled_ms: total time of the operators under the profiler, which slows them a little.
        kinds: kinds of operators, slowest first.
    """

    name: str
    ms: float
    least_ms: float
    profiled_ms: float
    kinds: tuple[OperatorKind, ...]


@dataclass(frozen=True)
class Roofline:
    """The peaks of the machine, and networks against them.

    Attributes:
        peak_gmac_s: billions of multiply-accumulates per second, of ``int8`` and ``fp32``.
        side: side of the matrices that the peaks were measured with.
        threads: threads for one frame.
        networks: results by network.
        machine: the machine that it ran on.
    """

    peak_gmac_s: Mapping[str, float]
    side: int
    threads: int
    networks: tuple[NetworkRoofline, ...]
    machine: Machine

    def as_json(self) -> str:
        """All values."""
        return json.dumps(asdict(self), indent=1) + "\n"

    def as_markdown(self) -> str:
        """Peaks, a summary, and a table per network."""
        peaks = ", ".join(f"{name} {rate:.0f}" for name, rate in self.peak_gmac_s.items())
        summary = [
            [
                each.name,
                f"{each.ms:.1f}",
                f"{each.least_ms:.1f}",
                f"{each.ms / each.least_ms:.2f}",
            ]
            for each in self.networks
        ]
        parts = [
            "## Roofline",
            f"Peak of onnxruntime's matrix product ({self.side} squared, {self.threads} "
            f"thread(s)), billion multiply-accumulates per second: {peaks}.",
            markdown_table(["network", "min ms", "ms at peak", "x ms at peak"], summary),
        ]
        for each in self.networks:
            rows = [
                [
                    kind.name,
                    str(kind.count),
                    f"{kind.ms:.2f}",
                    f"{kind.ms / each.profiled_ms:.0%}",
                    f"{kind.macs / 1e9:.2f}" if kind.macs else "",
                    "" if kind.of_peak is None else f"{kind.of_peak:.0%}",
                ]
                for kind in each.kinds
            ]
            columns = ["operator", "count", "ms", "share", "GMAC", "of peak"]
            parts += [f"### {each.name}", markdown_table(columns, rows)]
        parts.append(self.machine.as_markdown())
        return "\n\n".join(parts) + "\n"


def roofline(
    backends: Sequence[Backend],
    cache: ModelCache,
    machine: Machine,
    *,
    threads: int,
    trials: int,
    side: int = SIDE,
) -> Roofline:
    """Measures the peaks, then networks in onnxruntime.

    Args:
        backends: backends of the engine onnxruntime.
        cache: supplies their model files.
        machine: facts about the machine, from before the run.
        threads: threads for one frame.
        trials: timed frames of each.
        side: side of the matrices.
    """
    peaks = peak_gmac_s(side, threads, trials)
    networks = []
    for backend in backends:
        path = cache.onnx(backend.network, backend.size, backend.precision)
        image = np.random.default_rng(0).integers(0, 256, (1, *backend.size, 3), np.uint8)
        engine = OnnxRuntimeEngine(path, threads=threads)
        timed = measure({"network": partial(engine.run, image)}, trials)["network"]
        operators = profile(path, {"image": image}, threads=threads, frames=trials)
        min_ms = timed.summary().min_ms
        networks.append(compare_with_peaks(backend.name, min_ms, operators, peaks))
    return Roofline(peaks, side, threads, tuple(networks), machine)


def peak_gmac_s(side: int, threads: int, trials: int) -> dict[str, float]:
    """Rate of the fastest matrix product, int8 and float32, billion multiply-accumulates/s."""
    import onnxruntime as ort

    rng = np.random.default_rng(0)
    weights_int8 = rng.integers(-127, 128, (side, side)).astype(np.int8)
    given: dict[str, tuple[NDArray[np.generic], NDArray[np.generic]]] = {
        "int8": (rng.integers(0, 256, (side, side)).astype(np.uint8), weights_int8),
        "fp32": (
            rng.random((side, side), np.float32),
            rng.random((side, side), np.float32),
        ),
    }
    runs = {}
    with TemporaryDirectory() as folder:
        for name, (left, right) in given.items():
            path = Path(folder, f"{name}.onnx")
            _save_product(path, "MatMulInteger" if name == "int8" else "MatMul", left, right)
            options = ort.SessionOptions()
            options.intra_op_num_threads = threads
            options.log_severity_level = 4
            session = ort.InferenceSession(path, options, providers=["CPUExecutionProvider"])
            runs[name] = lambda s=session, x=left: s.run(None, {"x": x})
    timed = measure(runs, max(trials, PEAK_TRIALS))
    return {name: side**3 / (found.summary().min_ms / 1000) / 1e9 for name, found in timed.items()}


def compare_with_peaks(
    name: str, ms: float, operators: Sequence[Operator], peaks: Mapping[str, float]
) -> NetworkRoofline:
    """Compares the operators of a network with the peaks.

    Args:
        name: name of the network.
        ms: its fastest frame.
        operators: its operators, from the profiler.
        peaks: billions of multiply-accumulates per second, of ``int8`` and ``fp32``.
    """
    groups: dict[str, list[Operator]] = {}
    for each in operators:
        groups.setdefault(f"{each.kind} {each.input_type}".strip(), []).append(each)
    kinds = []
    least_ms = 0.0
    for label, group in groups.items():
        macs, spent_ms = sum(each.macs for each in group), sum(each.ms for each in group)
        group_least_ms = macs / 1e6 / peaks[_NAMES[group[0].is_integer]]
        least_ms += group_least_ms
        of_peak = group_least_ms / spent_ms if macs and spent_ms else None
        kinds.append(OperatorKind(label, len(group), spent_ms, macs, of_peak))
    kinds.sort(key=lambda kind: -kind.ms)
    return NetworkRoofline(name, ms, least_ms, sum(kind.ms for kind in kinds), tuple(kinds))


def _save_product(
    path: Path, operator: str, left: NDArray[np.generic], right: NDArray[np.generic]
) -> None:
    import onnx
    from onnx import TensorProto, helper, numpy_helper

    is_integer = operator == "MatMulInteger"
    made = TensorProto.INT32 if is_integer else TensorProto.FLOAT
    graph = helper.make_graph(
        [helper.make_node(operator, ["x", "weights"], ["y"])],
        "product",
        [
            helper.make_tensor_value_info(
                "x", helper.np_dtype_to_tensor_dtype(left.dtype), left.shape
            )
        ],
        [helper.make_tensor_value_info("y", made, (left.shape[0], right.shape[1]))],
        [numpy_helper.from_array(right, "weights")],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=10)
    onnx.save(model, path)
