"""How far each network is from what the machine can multiply, operator by operator.

The peak is what onnxruntime's own matrix product reaches here, at a size that suits it. Nothing
in a network can be faster than its multiply-additions at that rate, but for algorithms that need
fewer of them.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from footprints_edge.engines.onnxruntime_engine import OnnxRuntimeEngine
from footprints_edge_bench.engines.backend import Backend
from footprints_edge_bench.engines.ort_profile import Operator, profile
from footprints_edge_bench.latency.machine import Machine
from footprints_edge_bench.latency.tables import table
from footprints_edge_bench.latency.timing import measure
from footprints_edge_bench.model_files.model_cache import ModelCache

SIDE = 1536
"""Of the square matrices; their product is 3.6 billion multiply-additions."""

PEAK_TRIALS = 30
"""At least so many products are timed: the peak is the fastest of them."""

_NAMES = {True: "int8", False: "fp32"}


@dataclass(frozen=True)
class OperatorKind:
    """All operators of one kind in a network.

    Attributes:
        name: type, and what its numbers are, such as ``QLinearConv uint8``.
        count: how many.
        ms: all of them together, a frame.
        macs: multiply-additions of all of them, as executed; 0 where it has none.
        of_peak: rate, as a share of the peak of its precision; None where it has no macs.
    """

    name: str
    count: int
    ms: float
    macs: int
    of_peak: float | None


@dataclass(frozen=True)
class NetworkRoof:
    """A network under its roof.

    Attributes:
        name: network, size and precision.
        ms: fastest frame, without the profiler.
        least_ms: its multiply-additions at the peaks of their precisions.
        profiled_ms: sum of the operators under the profiler, which slows them a little.
        kinds: by time, longest first.
    """

    name: str
    ms: float
    least_ms: float
    profiled_ms: float
    kinds: tuple[OperatorKind, ...]


@dataclass(frozen=True)
class Roofline:
    """The machine's peaks and the networks below them.

    Attributes:
        peak_gmac_s: billions of multiply-additions a second, of ``int8`` and ``fp32``.
        side: of the matrices they were measured with.
        threads: of one frame.
        networks: measured.
        machine: that it ran on.
    """

    peak_gmac_s: Mapping[str, float]
    side: int
    threads: int
    networks: tuple[NetworkRoof, ...]
    machine: Machine

    def as_json(self) -> str:
        """Everything."""
        return json.dumps(asdict(self), indent=1) + "\n"

    def as_markdown(self) -> str:
        """Peaks, a summary, and a table a network."""
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
            f"thread(s)), billion multiply-additions a second: {peaks}.",
            table(["network", "fastest ms", "ms at peak", "times the least"], summary),
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
            parts += [f"### {each.name}", table(columns, rows)]
        parts.append(self.machine.as_markdown())
        return "\n\n".join(parts) + "\n"


def roofline(
    rows: Sequence[Backend],
    files: ModelCache,
    machine: Machine,
    *,
    threads: int,
    trials: int,
    side: int = SIDE,
) -> Roofline:
    """Measures the peaks, then networks in onnxruntime.

    Args:
        rows: of the engine onnxruntime.
        files: where their model files come from.
        machine: as it was before.
        threads: of one frame.
        trials: timed frames of each.
        side: of the matrices.
    """
    peaks = peak_gmac_s(side, threads, trials)
    networks = []
    for row in rows:
        path = files.onnx(row.network, row.size, row.precision)
        image = np.random.default_rng(0).integers(0, 256, (1, *row.size, 3), np.uint8)
        session = OnnxRuntimeEngine(path, threads=threads)
        timed = measure({row.name: lambda s=session, i=image: s.run(i)}, trials)  # type: ignore[misc]
        operators = profile(path, {"image": image}, threads=threads, frames=trials)
        networks.append(under_roof(row.name, timed[row.name].summary().min_ms, operators, peaks))
    return Roofline(peaks, side, threads, tuple(networks), machine)


def peak_gmac_s(side: int, threads: int, trials: int) -> dict[str, float]:
    """Fastest matrix product, uint8 by int8 and float32, in billion multiply-additions a second."""
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


def under_roof(
    name: str, ms: float, operators: Sequence[Operator], peaks: Mapping[str, float]
) -> NetworkRoof:
    """Sorts a network's operators under the peaks.

    Args:
        name: of the network.
        ms: its fastest frame.
        operators: from the profiler.
        peaks: of ``int8`` and ``fp32``, billion multiply-additions a second.
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
    return NetworkRoof(name, ms, least_ms, sum(kind.ms for kind in kinds), tuple(kinds))


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
