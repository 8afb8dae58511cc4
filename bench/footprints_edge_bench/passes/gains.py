"""Speed-up of each graph pass, measured on the graphs after each pass in one interleaved run."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import median
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Size
from footprints_edge_bench.foundation.markdown import markdown_table
from footprints_edge_bench.latency.timing import interleaved_ms
from footprints_edge_bench.model_files.random_weights import with_calibrated_random_weights
from footprints_edge_bench.model_files.stock_files import stock_graph
from footprints_edge_bench.model_files.synthetic_photos import synthetic_photo

if TYPE_CHECKING:
    import onnx
    import onnxruntime
    from torch import nn

AS_EXPORTED = "as exported"


@dataclass(frozen=True)
class PassGain:
    """Times of a graph after one more pass than the graph before.

    Attributes:
        name: name of the pass, or :data:`AS_EXPORTED`.
        min_ms: fastest frame, network alone.
        median_ms: median frame.
        of_before: time as a multiple of the graph before, median over rounds.
        of_first: time as a multiple of the graph as exported, median over rounds.
    """

    name: str
    min_ms: float
    median_ms: float
    of_before: float
    of_first: float


def measure_gains(
    architecture: str, precision: str, size: Size, threads: int, trials: int
) -> list[PassGain]:
    """Exports a network with calibrated random weights and times it after each pass.

    Args:
        architecture: key of the exporter's ``ARCHITECTURES``. All passes are applied, even those
            that a conversion of this architecture leaves out.
        precision: ``fp32`` or ``int8``.
        size: (H, W).
        threads: threads of onnxruntime.
        trials: timed frames of each graph.
    """
    from footprints_edge_export.architectures import ARCHITECTURES

    images = [synthetic_photo(size, seed)[None] for seed in range(2)]
    exported = ARCHITECTURES[architecture]
    whole = with_calibrated_random_weights(exported.network.build(), images)
    network = exported.part(whole, "all", 1).eval()
    image = np.random.default_rng(0).integers(0, 256, (1, *size, 3), dtype=np.uint8)
    sessions = {
        name: session_of(model, threads)
        for name, model in variants(network, precision, size, images)
    }
    runs: dict[str, Callable[[], object]] = {
        name: partial(session.run, None, {"image": image}) for name, session in sessions.items()
    }
    return summarise(interleaved_ms(runs, trials))


def summarise(times_ms: dict[str, list[float]]) -> list[PassGain]:
    """Gains from the times of every graph, in the order of the passes."""
    names = list(times_ms)
    first = np.array(times_ms[names[0]])
    gains = []
    for before, name in zip([names[0], *names], names, strict=False):
        times = np.array(times_ms[name])
        gains.append(
            PassGain(
                name,
                float(times.min()),
                float(median(times)),
                float(np.median(times / np.array(times_ms[before]))),
                float(np.median(times / first)),
            )
        )
    return gains


def gains_as_markdown(gains: Sequence[PassGain]) -> str:
    """A table with one row per pass."""
    columns = ["after pass", "min ms", "median ms", "x previous row", "x as exported"]
    rows = [
        [g.name, f"{g.min_ms:.1f}", f"{g.median_ms:.1f}", f"{g.of_before:.2f}", f"{g.of_first:.2f}"]
        for g in gains
    ]
    return markdown_table(columns, rows) + "\n"


def variants(
    network: "nn.Module", precision: str, size: Size, images: Sequence[NDArray[np.uint8]]
) -> Iterator[tuple[str, "onnx.ModelProto"]]:
    """The graph of a network as exported, then after each further pass.

    Args:
        network: RGB float32 (1, 3, H, W) in [0, 1] to maps, as conversions export it.
        precision: ``fp32`` or ``int8``.
        size: (H, W).
        images: calibration images for int8, uint8 (1, H, W, 3) each.
    """
    from footprints_edge_export.graph.editing import to_proto
    from footprints_edge_export.passes.registry import PASSES, PassStage

    model = stock_graph(network, precision, size, images)
    yield AS_EXPORTED, to_proto(model)
    for each in PASSES:
        if each.stage in (PassStage.FLOAT, PassStage(precision)):
            each.rewrite(model)
            yield each.name, to_proto(model)


def session_of(model: "onnx.ModelProto", threads: int) -> "onnxruntime.InferenceSession":
    """A session of onnxruntime that runs a graph on the CPU."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.log_severity_level = 3
    return onnxruntime.InferenceSession(
        model.SerializeToString(), options, providers=["CPUExecutionProvider"]
    )
