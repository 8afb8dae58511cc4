"""Which backends to measure."""

from collections.abc import Sequence
from pathlib import Path

from footprints_edge.engines.onnxruntime_engine import OnnxRuntimeEngine
from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.types import Size
from footprints_edge.model_files.metadata import ModelMetadata
from footprints_edge_bench.engines.backend import Backend
from footprints_edge_bench.engines.open_backend import ENGINES
from footprints_edge_bench.model_files.model_cache import EDGE, REFERENCE, STOCK

PRESETS: dict[str, Size] = {
    "kitti": (192, 640),
    "handheld": (256, 448),
    "matterport": (512, 640),
}
"""Input sizes (H, W) of the paper's three published networks."""


class LatencyError(FootprintsError):
    """A latency benchmark cannot be run as requested."""


def select_backends(
    only: Sequence[str] = (), models: Sequence[str] = (), sizes: Sequence[Size] = ()
) -> list[Backend]:
    """The backends to measure.

    Args:
        only: texts; backends whose name contains one of them are selected, or all if there are
            none.
        models: further model files, run by onnxruntime at their own size, or at that of
            ``handheld`` if it is not fixed.
        sizes: sizes (H, W) of the reference network; ``PRESETS`` if there are none.

    Raises:
        LatencyError: no backend's name contains one of the texts.
    """
    networks = [(EDGE, PRESETS["handheld"])]
    networks += [(REFERENCE, size) for size in sizes or PRESETS.values()]
    found = [
        Backend(network, size, engine, precision)
        for network, size in networks
        for engine, precisions in ENGINES.items()
        for precision in precisions
        # The edge network has one head, and no graph pass applies to it.
        if network != EDGE or not (precision.endswith(STOCK) or "-scale" in precision)
    ]
    found += [of_model_file(model) for model in models]
    for text in only:
        if not any(text in each.name for each in found):
            raise LatencyError(
                f"--only {text!r} matches no row; choose from:\n"
                + "\n".join(f"  {each.name}" for each in found)
            )
    return [each for each in found if not only or any(text in each.name for text in only)]


def of_model_file(model: str) -> Backend:
    """A model file in onnxruntime, at its own size, or at that of ``handheld`` if it has none."""
    engine = OnnxRuntimeEngine(Path(model), threads=1)
    precision = ModelMetadata.from_props(engine.props, model).precision
    size = engine.input_size or PRESETS["handheld"]
    return Backend(model, size, "onnxruntime", precision)
