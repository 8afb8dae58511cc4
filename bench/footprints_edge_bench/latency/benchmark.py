"""The latency benchmark: networks in engines, timed in turns, with their accuracy."""

from collections.abc import Callable, Mapping, Sequence
from itertools import permutations

from footprints_edge.engines.onnxruntime_engine import OnnxRuntimeEngine
from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.types import Floats, Rgb, Size
from footprints_edge_bench.engines.backend import (
    Backend,
    BackendError,
    BackendSetting,
    LoadedBackend,
)
from footprints_edge_bench.engines.open_backend import as_frame, open_backend
from footprints_edge_bench.latency.comparison_photos import SYNTHETIC_PHOTOS, synthetic_images
from footprints_edge_bench.latency.machine import Machine
from footprints_edge_bench.latency.report import LatencyReport, LatencyRow
from footprints_edge_bench.latency.timing import Ratio, Trials, measure, ratio
from footprints_edge_bench.model_files.model_cache import (
    EDGE,
    REFERENCE,
    STOCK,
    outputs_of,
    part_of,
)


def time_backends(
    backends: Sequence[Backend],
    setting: BackendSetting,
    machine: Machine,
    trials: int,
    photos: Mapping[Size, Sequence[Rgb]] | None = None,
    progress: Callable[[str], None] | None = None,
) -> LatencyReport:
    """Times backends: those of one size in turns, one size after the other.

    Args:
        backends: what to measure.
        setting: how they are run.
        machine: facts about the machine, from before the run.
        trials: timed frames of each.
        photos: photos to compare the maps on, uint8 (1, H, W, 3), by size; None for synthetic ones.
        progress: called with the name of a backend after each of its trials.
    """
    found: dict[str, LatencyRow] = {}
    ratios: dict[str, dict[str, Ratio]] = {}
    for size in dict.fromkeys(backend.size for backend in backends):
        images = synthetic_images(size) if photos is None else photos[size]
        group = [backend for backend in backends if backend.size == size]
        rows = _measure_size(group, setting, trials, images, progress)
        found |= {row.name: row for row in rows}
        for row, other in permutations([row for row in rows if row.times_ms], 2):
            ratios.setdefault(row.name, {})[other.name] = ratio(row.times_ms, other.times_ms)
    return LatencyReport(
        machine=machine,
        threads=setting.threads,
        spinning=str(setting.spinning),
        trials=trials,
        photos=f"{SYNTHETIC_PHOTOS} synthetic photos"
        if photos is None
        else f"{len(next(iter(photos.values())))} photos",
        rows=tuple(found[backend.name] for backend in backends),
        ratios=ratios,
    )


def _measure_size(
    group: Sequence[Backend],
    setting: BackendSetting,
    trials: int,
    images: Sequence[Rgb],
    progress: Callable[[str], None] | None,
) -> list[LatencyRow]:
    """Rows of backends of one size."""
    loaded: dict[Backend, LoadedBackend] = {}
    reasons: dict[Backend, str] = {}
    for backend in group:
        try:
            loaded[backend] = open_backend(backend, setting)
        except BackendError as error:
            reasons[backend] = str(error)
    frames = {backend.name: as_frame(each, images[0]) for backend, each in loaded.items()}
    timed = measure(frames, trials, progress=progress)
    parts = {(backend.network, part_of(backend.precision)) for backend in loaded}
    expected = {part: _float32_maps(*part, setting, images) for part in parts}
    return [
        LatencyRow(backend=backend, reason=reasons[backend])
        if backend in reasons
        else _row(
            backend,
            loaded[backend],
            timed[backend.name],
            images,
            expected[backend.network, part_of(backend.precision)],
        )
        for backend in group
    ]


def _row(
    backend: Backend,
    loaded: LoadedBackend,
    trials: Trials,
    images: Sequence[Rgb],
    expected: Sequence[Floats] | None,
) -> LatencyRow:
    from footprints_edge_export.verification.compare import all_four, compare_maps

    accuracy = None
    if expected is not None:
        outputs = outputs_of(backend.precision)
        maps = [all_four(loaded.run(image), outputs) for image in images]
        floats = [all_four(each, outputs) for each in expected]
        accuracy = compare_maps(zip(floats, maps, strict=True)).as_dict()
        if outputs == "masks":
            accuracy["visible_depth_abs_rel"] = None
        if outputs == "depths":
            accuracy["ground_iou"] = None
    return LatencyRow(
        backend=backend,
        precision=loaded.precision,
        file_bytes=loaded.file_bytes,
        accuracy=accuracy,
        summary=trials.summary(),
        times_ms=trials.times_ms,
    )


def _float32_maps(
    network: str, part: str, setting: BackendSetting, images: Sequence[Rgb]
) -> list[Floats] | None:
    """Maps of a network's float32 file, stock or of a part; None if there is no such file."""
    _, height, width, _ = images[0].shape
    if network not in (EDGE, REFERENCE):
        return None
    try:
        engine = OnnxRuntimeEngine(
            setting.cache.onnx(network, (height, width), f"fp32{part or STOCK}")
        )
    except FootprintsError:
        return None
    return [engine.run(image) for image in images]
