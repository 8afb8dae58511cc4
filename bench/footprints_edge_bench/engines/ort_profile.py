"""Profiles a model file with onnxruntime, operator by operator."""

import json
import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

_WEIGHTS_INPUT = {
    "Conv": 1,
    "FusedConv": 1,
    "ConvInteger": 1,
    "QLinearConv": 3,
    "MatMul": 1,
    "FusedMatMul": 1,
    "Gemm": 1,
    "MatMulInteger": 1,
    "DynamicQuantizeMatMul": 1,
    "MatMulIntegerToFloat": 1,
    "QLinearMatMul": 3,
    "QGemm": 3,
}
"""Operators with multiply-accumulates, and the index of the input with their weights."""

_INTEGER = {"int8", "uint8"}


@dataclass(frozen=True)
class Operator:
    """One operator of the graph after onnxruntime's optimisation.

    Attributes:
        kind: operator type, such as ``QLinearConv``.
        ms: median wall time per frame.
        macs: multiply-accumulates per frame, as executed: padded channels count.
        input_type: type of its first input, such as ``uint8``.
    """

    kind: str
    ms: float
    macs: int
    input_type: str

    @property
    def is_convolution(self) -> bool:
        """Whether this is a convolution."""
        return "Conv" in self.kind

    @property
    def is_integer(self) -> bool:
        """Whether this operator multiplies 8-bit integers."""
        return self.kind in _WEIGHTS_INPUT and self.input_type in _INTEGER


def profile(
    path: Path, feeds: Mapping[str, NDArray[np.generic]], *, threads: int, frames: int
) -> tuple[Operator, ...]:
    """Runs a model file under the profiler, after one untimed frame.

    Args:
        path: the model file.
        feeds: inputs by name.
        threads: threads for one frame.
        frames: number of timed frames.

    Returns:
        The operators in the order in which they ran.
    """
    import onnxruntime as ort

    with tempfile.TemporaryDirectory() as folder:
        optimised = Path(folder, "optimised.onnx")
        options = ort.SessionOptions()
        options.intra_op_num_threads = threads
        options.inter_op_num_threads = 1
        options.log_severity_level = 4
        options.add_session_config_entry("session.force_spinning_stop", "1")
        options.optimized_model_filepath = str(optimised)
        options.enable_profiling = True
        options.profile_file_prefix = str(Path(folder, "profile"))
        session = ort.InferenceSession(path, options, providers=["CPUExecutionProvider"])
        for _ in range(1 + frames):
            session.run(None, dict(feeds))
        events = json.loads(Path(session.end_profiling()).read_text(encoding="utf-8"))
        return operators(events, frames, _weights(optimised))


def operators(
    events: Sequence[Mapping[str, Any]], frames: int, weights: Mapping[str, Sequence[int]]
) -> tuple[Operator, ...]:
    """Operators from the profiler's events, one per operator in each of ``1 + frames`` frames.

    Args:
        events: events of the profiler.
        frames: number of timed frames, the last ones.
        weights: shape of the weights by operator name; the profiler does not report the weights
            that a kernel has repacked.
    """
    by_node: dict[str, list[Mapping[str, Any]]] = {}
    for event in events:
        if event["cat"] == "Node":
            by_node.setdefault(event["args"]["node_index"], []).append(event)
    return tuple(_operator(found, frames, weights) for found in by_node.values())


def convolutions(found: Sequence[Operator]) -> dict[str, int]:
    """Number of convolutions by precision: int8 and floats."""
    kinds: dict[str, int] = {}
    for operator in found:
        if operator.is_convolution:
            kind = (
                "int8" if operator.is_integer else operator.input_type.replace("float", "float32")
            )
            kinds[kind] = kinds.get(kind, 0) + 1
    return kinds


def _operator(
    events: Sequence[Mapping[str, Any]], frames: int, weights: Mapping[str, Sequence[int]]
) -> Operator:
    arguments = events[0]["args"]
    inputs = [next(iter(each.items())) for each in arguments["input_type_shape"] if each]
    kind = arguments["op_name"]
    macs = 0
    if shape := weights.get(events[0]["name"].removesuffix("_kernel_time")):
        (made,) = list(arguments["output_type_shape"][0].values())
        macs = math.prod(made) * math.prod(shape[1:] if "Conv" in kind else shape[:1])
    timed = sorted(events, key=lambda event: event["ts"])[-frames:]
    ms = median(event["dur"] for event in timed) / 1000
    # The first input that is not a scalar: some operators take scales before data.
    types = [dtype for dtype, shape in inputs if shape] or [dtype for dtype, _ in inputs]
    return Operator(kind, ms, macs, types[0] if types else "")


def _weights(path: Path) -> dict[str, list[int]]:
    """Shapes of the weights in a file, by the name of their operator."""
    import onnx

    graph = onnx.load(path).graph
    shapes = {tensor.name: list(tensor.dims) for tensor in graph.initializer}
    return {
        node.name: shapes[node.input[_WEIGHTS_INPUT[node.op_type]]]
        for node in graph.node
        if node.op_type in _WEIGHTS_INPUT and node.input[_WEIGHTS_INPUT[node.op_type]] in shapes
    }
