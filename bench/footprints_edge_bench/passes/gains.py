"""What each graph pass gains: a network's file after one pass more, all in one interleaved run."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Size
from footprints_edge_bench.latency.timing import interleaved_ms
from footprints_edge_bench.model_files.random_weights import with_lively_weights
from footprints_edge_bench.model_files.stock_files import stock_graph
from footprints_edge_bench.model_files.synthetic_photos import made_photo

if TYPE_CHECKING:
    import onnx
    import onnxruntime
    from torch import nn

AS_EXPORTED = "as exported"


@dataclass(frozen=True)
class Gain:
    """A file after one pass more than the one before.

    Attributes:
        name: of the pass, or :data:`AS_EXPORTED`.
        min_ms: its fastest frame, network alone.
        median_ms: its median frame.
        of_before: median of its times by those of the file before, round by round.
        of_first: likewise by those of the file as exported.
    """

    name: str
    min_ms: float
    median_ms: float
    of_before: float
    of_first: float


def measure_gains(
    architecture: str, precision: str, size: Size, threads: int, trials: int
) -> list[Gain]:
    """Export a network with random weights and time it after each of its passes.

    Args:
        architecture: key of the exporter's ``ARCHITECTURES``. All passes are tried, also those
            that its conversion leaves out.
        precision: ``fp32`` or ``int8``.
        size: (H, W).
        threads: of onnxruntime.
        trials: timed frames of each file.
    """
    from footprints_edge_export.architectures import ARCHITECTURES

    pictures = [made_photo(size, seed)[None] for seed in range(2)]
    network = with_lively_weights(ARCHITECTURES[architecture].build(), pictures)
    image = np.random.default_rng(0).integers(0, 256, (1, *size, 3), dtype=np.uint8)
    sessions = {
        name: session_of(model, threads)
        for name, model in variants(network, precision, size, pictures)
    }
    runs: dict[str, Callable[[], object]] = {
        name: partial(session.run, None, {"image": image}) for name, session in sessions.items()
    }
    return summarise(interleaved_ms(runs, trials))


def summarise(times_ms: dict[str, list[float]]) -> list[Gain]:
    """Times of every file, in the order of the passes, to gains."""
    names = list(times_ms)
    first = np.array(times_ms[names[0]])
    gains = []
    for before, name in zip([names[0], *names], names, strict=False):
        times = np.array(times_ms[name])
        gains.append(
            Gain(
                name,
                float(times.min()),
                float(median(times)),
                float(np.median(times / np.array(times_ms[before]))),
                float(np.median(times / first)),
            )
        )
    return gains


def gains_as_markdown(gains: Sequence[Gain]) -> str:
    """A table, one pass a row."""
    lines = [
        "| after | fastest, ms | median, ms | x the row before | x as exported |",
        "| --- | ---: | ---: | ---: | ---: |",
    ]
    lines += [
        f"| {g.name} | {g.min_ms:.1f} | {g.median_ms:.1f} | {g.of_before:.2f} | {g.of_first:.2f} |"
        for g in gains
    ]
    return "\n".join(lines) + "\n"


def variants(
    network: "nn.Module", precision: str, size: Size, pictures: Sequence[NDArray[np.uint8]]
) -> Iterator[tuple[str, "onnx.ModelProto"]]:
    """A network's graph as exported, and after each pass more.

    Args:
        network: RGB float32 (B, 3, H, W) in [0, 1] to raw channels.
        precision: ``fp32`` or ``int8``.
        size: (H, W).
        pictures: that int8 is calibrated on, uint8 (1, H, W, 3) each.
    """
    from footprints_edge_export.graph.editing import to_proto
    from footprints_edge_export.passes.registry import PASSES, PassStage

    model = stock_graph(network, precision, size, pictures)
    yield AS_EXPORTED, to_proto(model)
    for each in PASSES:
        if each.stage in (PassStage.FLOAT, PassStage(precision)):
            each.rewrite(model)
            yield each.name, to_proto(model)


def session_of(model: "onnx.ModelProto", threads: int) -> "onnxruntime.InferenceSession":
    """A graph in onnxruntime on the CPU."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.log_severity_level = 3
    return onnxruntime.InferenceSession(
        model.SerializeToString(), options, providers=["CPUExecutionProvider"]
    )
