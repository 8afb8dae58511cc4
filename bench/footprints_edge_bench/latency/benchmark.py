"""The latency benchmark: networks in engines, in turns, with their accuracy beside them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from pathlib import Path
from typing import Any

from footprints_edge.cli.sources import expand
from footprints_edge.engines.onnxruntime_engine import OnnxRuntimeEngine
from footprints_edge.errors import FootprintsError, ImageError
from footprints_edge.foundation.types import Floats, Rgb, Size
from footprints_edge.inputs.images import decode
from footprints_edge.inputs.preprocessing import enough_for, preprocess
from footprints_edge.model_files.metadata import ModelMetadata
from footprints_edge_bench.engines.backend import (
    Backend,
    BackendSetting,
    EngineError,
    LoadedBackend,
)
from footprints_edge_bench.engines.open_backend import ENGINES, as_frame, open_backend
from footprints_edge_bench.latency.machine import Machine
from footprints_edge_bench.latency.timing import Ratio, TimingSummary, Trials, measure, ratio
from footprints_edge_bench.model_files.model_cache import (
    EDGE,
    REFERENCE,
    STOCK,
    outputs_of,
    part_of,
)
from footprints_edge_bench.model_files.synthetic_photos import synthetic_photo

PRESETS: dict[str, Size] = {
    "kitti": (192, 640),
    "handheld": (256, 448),
    "matterport": (512, 640),
}
"""Input sizes of the paper's three published networks."""

PHOTOS = 4
"""So many made-up photos the maps are compared on, if no others are given."""

MOST_PHOTOS = 50
"""And on so many of those that are given."""

BASELINE = "torch fp32"
"""What the ratios in the table are against: the reference in this engine and precision."""


class LatencyError(FootprintsError):
    """A latency benchmark that cannot be run as it is asked for."""


@dataclass(frozen=True)
class LatencyRow:
    """What was found of a contender.

    Attributes:
        contender: what was asked for.
        reason: why it did not run; None if it did.
        precision: that it really ran in, read back from the engine.
        file_bytes: size of its model files.
        accuracy: of its maps against onnxruntime's float32, see
            ``footprints_edge_export.compare.Difference``; None where there is no such file.
        summary: its times.
        times_ms: the same, one by one, in the order of the rounds.
    """

    backend: Backend
    reason: str | None = None
    precision: str | None = None
    file_bytes: int | None = None
    accuracy: dict[str, Any] | None = None
    summary: TimingSummary | None = None
    times_ms: tuple[float, ...] = ()

    @property
    def name(self) -> str:
        """Of its contender."""
        return self.backend.name


@dataclass(frozen=True)
class LatencyReport:
    """One run.

    Attributes:
        machine: that it ran on.
        threads: of one frame.
        spinning: of onnxruntime's threads, see ``Spinning``.
        trials: rounds.
        photos: what the maps were compared on, in words.
        rows: in the order of the contenders. Those of one size were timed in turns.
        ratios: of every two rows of one size that ran: times as long, first against second.
    """

    machine: Machine
    threads: int
    spinning: str
    trials: int
    photos: str
    rows: tuple[LatencyRow, ...]
    ratios: dict[str, dict[str, Ratio]]

    def failed(self) -> bool:
        """Whether a row of onnxruntime did not run, or none did; a missing peer is no failure."""
        missing = [row for row in self.rows if row.reason is not None]
        ours = any(row.backend.engine == "onnxruntime" for row in missing)
        return ours or len(missing) == len(self.rows)

    def baseline(self, size: Size) -> LatencyRow | None:
        """The row that others of its size are compared with in the table, if there is one."""
        ran = [row for row in self.rows if row.backend.size == size and row.summary]
        named = f"{REFERENCE} {size[0]}x{size[1]} {BASELINE}"
        return next((row for row in ran if row.name == named), next(iter(ran), None))


def select_backends(
    only: Sequence[str] = (), models: Sequence[str] = (), sizes: Sequence[Size] = ()
) -> list[Backend]:
    """The rows to measure.

    Args:
        only: texts; a row is taken whose name holds one of them. None takes all.
        models: further model files, run by onnxruntime at the size of ``handheld``, or their own.
        sizes: of the reference network; None takes ``PRESETS``.

    Raises:
        LatencyError: a text fits no row.
    """
    networks = [(EDGE, PRESETS["handheld"])]
    networks += [(REFERENCE, size) for size in sizes or PRESETS.values()]
    found = [
        Backend(network, size, engine, precision)
        for network, size in networks
        for engine, precisions in ENGINES.items()
        for precision in precisions
        # The edge network has one head, and its graph is not rewritten.
        if network != EDGE or not (precision.endswith(STOCK) or "-scale" in precision)
    ]
    for model in models:
        session = OnnxRuntimeEngine(Path(model), threads=1)
        precision = ModelMetadata.from_props(session.props, model).precision
        size = session.input_size or PRESETS["handheld"]
        found.append(Backend(model, size, "onnxruntime", precision))
    for text in only:
        if not any(text in each.name for each in found):
            raise LatencyError(
                f"--only {text!r} fits no row; there are:\n"
                + "\n".join(f"  {each.name}" for each in found)
            )
    return [each for each in found if not only or any(text in each.name for text in only)]


def run(
    rows: Sequence[Backend],
    setting: BackendSetting,
    machine: Machine,
    trials: int,
    photos: Mapping[Size, Sequence[Rgb]] | None = None,
    progress: Callable[[str], None] | None = None,
) -> LatencyReport:
    """Measures rows: those of one size in turns, size after size.

    Args:
        rows: what to measure.
        setting: how they are run.
        machine: as it was before.
        trials: timed frames of each.
        photos: by size, uint8 (1, H, W, 3), that the maps are compared on; made-up ones if None.
        progress: told a row's name after each of its trials.
    """
    found: dict[str, LatencyRow] = {}
    ratios: dict[str, dict[str, Ratio]] = {}
    for size in dict.fromkeys(row.size for row in rows):
        images = synthetic_images(size) if photos is None else photos[size]
        group = [row for row in rows if row.size == size]
        measured = _measure_size(group, setting, trials, images, progress)
        found |= {row.name: row for row in measured}
        for row, other in permutations([row for row in measured if row.times_ms], 2):
            ratios.setdefault(row.name, {})[other.name] = ratio(row.times_ms, other.times_ms)
    count = PHOTOS if photos is None else len(next(iter(photos.values())))
    words = f"{count} made-up photos" if photos is None else f"{count} photos"
    return LatencyReport(
        machine,
        setting.threads,
        str(setting.spinning),
        trials,
        words,
        tuple(found[row.name] for row in rows),
        ratios,
    )


def synthetic_images(size: Size) -> list[Rgb]:
    """Made-up photos as the network sees them, uint8 (1, H, W, 3); none is calibrated on."""
    return [synthetic_photo(size, 1000 + seed)[None] for seed in range(PHOTOS)]


def photos_by_size(folder: Path, rows: Sequence[Backend]) -> dict[Size, list[Rgb]]:
    """At most 50 photos of a folder as the networks see them, by the size of the rows.

    Raises:
        LatencyError: the folder holds no picture that can be read.
        ImageError: there is no such folder.
    """
    paths = [source.path for source in expand(str(folder), recursive=True) if source.path]
    step = max(1, -(-len(paths) // MOST_PHOTOS))
    sizes = {row.size for row in rows}
    largest = enough_for((max(h for h, _ in sizes), max(w for _, w in sizes)))
    photos = []
    for path in paths[::step]:
        try:
            photos.append(decode(path, lambda _: largest).pixels)
        except ImageError:
            continue
    if not photos:
        raise LatencyError(f"{folder}: none of its {len(paths)} pictures can be read")
    return {size: [preprocess(photo, size) for photo in photos] for size in sizes}


def _measure_size(
    group: Sequence[Backend],
    setting: BackendSetting,
    trials: int,
    images: Sequence[Rgb],
    progress: Callable[[str], None] | None,
) -> list[LatencyRow]:
    running: dict[str, LoadedBackend] = {}
    reasons: dict[str, str] = {}
    for backend in group:
        try:
            running[backend.name] = open_backend(backend, setting)
        except EngineError as error:
            reasons[backend.name] = str(error)
    frames = {name: as_frame(each, images[0]) for name, each in running.items()}
    timed = measure(frames, trials, progress=progress)
    expected = {
        (network, part): _float_maps(network, part, setting, images)
        for network, part in {
            (backend.network, part_of(backend.precision))
            for backend in group
            if backend.name in running
        }
    }
    return [
        LatencyRow(backend, reason=reasons[backend.name])
        if backend.name in reasons
        else _row(
            backend,
            running[backend.name],
            timed[backend.name],
            images,
            expected[backend.network, part_of(backend.precision)],
        )
        for backend in group
    ]


def _row(
    backend: Backend,
    running: LoadedBackend,
    trials: Trials,
    images: Sequence[Rgb],
    expected: Sequence[Floats] | None,
) -> LatencyRow:
    from footprints_edge_export.verification.compare import all_four, compare_maps

    accuracy = None
    if expected is not None:
        outputs = outputs_of(backend.precision)
        maps = [all_four(running.run(image), outputs) for image in images]
        floats = [all_four(each, outputs) for each in expected]
        accuracy = compare_maps(zip(floats, maps, strict=True)).as_dict()
        if outputs == "masks":
            accuracy["visible_depth_abs_rel"] = None
        if outputs == "depths":
            accuracy["ground_iou"] = None
    return LatencyRow(
        backend,
        precision=running.precision,
        file_bytes=running.file_bytes,
        accuracy=accuracy,
        summary=trials.summary(),
        times_ms=trials.times_ms,
    )


def _float_maps(
    network: str, part: str, setting: BackendSetting, images: Sequence[Rgb]
) -> list[Floats] | None:
    """Maps of a network's float file, as exported or of a part; None where none is to be had."""
    _, height, width, _ = images[0].shape
    if network not in (EDGE, REFERENCE):
        return None
    try:
        session = OnnxRuntimeEngine(
            setting.files.onnx(network, (height, width), f"fp32{part or STOCK}")
        )
    except FootprintsError:
        return None
    return [session.run(image) for image in images]
