"""The paper's speed table: its four rows as printed, and ours and its peers measured here."""

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.inputs.images import decode
from footprints_edge.inputs.preprocessing import enough_for, preprocess
from footprints_edge_bench.engines.backend import (
    Backend,
    BackendError,
    BackendSetting,
    LoadedBackend,
)
from footprints_edge_bench.engines.open_backend import as_frame, open_backend
from footprints_edge_bench.foundation.markdown import markdown_table
from footprints_edge_bench.latency.backends import PRESETS, LatencyError
from footprints_edge_bench.latency.machine import Machine
from footprints_edge_bench.latency.peer_rows import PEERS, PeerRow, time_peers
from footprints_edge_bench.latency.timing import measure
from footprints_edge_bench.model_files.model_cache import EDGE, REFERENCE
from footprints_edge_bench.model_files.synthetic_photos import synthetic_jpeg
from footprints_edge_bench.peers.peer import Peer


@dataclass(frozen=True)
class PaperRow:
    """A row as the paper prints it, measured by its authors on their hardware.

    Attributes:
        method: name in the paper.
        preprocessing_s: time of preprocessing; None where the paper has a dash.
        inference_s: time of inference for one image.
    """

    method: str
    preprocessing_s: float | None
    inference_s: float


PAPER = (
    PaperRow("Voxels (SSCNet)", 43, 66),
    PaperRow("Bounding box (Qi et al.)", None, 0.417),
    PaperRow("Bounding box (Mousavian et al.)", None, 0.520),
    PaperRow("Footprints, the paper's", None, 0.074),
)
"""Table "Single image inference speed comparison" of the paper."""

IMAGE_SIZES: dict[str, Size] = {
    "kitti": (375, 1242),
    "handheld": (720, 1280),
    "matterport": (1024, 1280),
}
"""(H, W) of the images that each preset is for."""

OURS = (
    (EDGE, "onnxruntime", "int8"),
    (REFERENCE, "onnxruntime", "int8"),
    (REFERENCE, "onnxruntime", "fp32"),
    (REFERENCE, "torch", "fp32"),
)
"""Network, engine and precision of each of our rows."""

PEER_TRIALS = 5
"""Timed frames of each peer at most: each takes seconds."""


@dataclass(frozen=True)
class OurRow:
    """A row that was measured on this machine.

    Attributes:
        preset: key of ``PRESETS``.
        backend: what was requested.
        reason: why it did not run; None if it did.
        precision: precision that it ran in.
        preprocessing_s: median time of decoding a JPEG of the preset's image size and resizing it.
        inference_s: median time of the network alone.
    """

    preset: str
    backend: Backend
    reason: str | None = None
    precision: str | None = None
    preprocessing_s: float | None = None
    inference_s: float | None = None


@dataclass(frozen=True)
class SpeedTable:
    """The table and the conditions of the measurement."""

    rows: tuple[OurRow, ...]
    peers: tuple[PeerRow, ...]
    threads: int
    trials: int
    machine: Machine

    def as_json(self) -> str:
        """All values."""
        return (
            json.dumps({"paper": [asdict(row) for row in PAPER], **asdict(self)}, indent=1) + "\n"
        )

    def as_markdown(self) -> str:
        """The table and the conditions of the measurement."""
        paper = [
            [each.method, "", "by the paper", _s(each.preprocessing_s), _s(each.inference_s)]
            for each in PAPER
        ]
        ours = [
            [
                f"{row.backend.network} in {row.backend.engine}, {row.precision}",
                f"{row.backend.size[0]}x{row.backend.size[1]} ({row.preset})",
                "here",
                _s(row.preprocessing_s),
                _s(row.inference_s),
            ]
            for row in self.rows
            if row.inference_s is not None
        ]
        columns = ["method", "size", "measured", "preprocessing (s)", "inference (s)"]
        parts = [markdown_table(columns, [*paper, *ours], left=3)]
        if self.peers:
            parts.append(self._peers_as_markdown())
        missing = [(row.backend.name, row.reason) for row in self.rows if row.reason]
        missing += [(f"{row.method}, {row.engine}", row.reason) for row in self.peers if row.reason]
        if missing:
            lines = (f"- {name}: {reason}" for name, reason in missing)
            parts.append("\n".join(["Not run:", "", *lines]))
        parts.append(
            f"Batch of one, {self.threads} thread(s), medians of {self.trials} rounds in turns. "
            "Preprocessing decodes a JPEG of the dataset's image size and resizes it. The paper's "
            "rows were measured on other hardware, so their times are not comparable with ours.\n\n"
            + self.machine.as_markdown()
        )
        return "\n\n".join(parts) + "\n"

    def _peers_as_markdown(self) -> str:
        """Networks of the peers' shape here, beside the paper's figure and our fastest row."""
        paper_s = {row.method: (row.preprocessing_s or 0) + row.inference_s for row in PAPER}
        ours = [(row.inference_s, row) for row in self.rows if row.inference_s is not None]
        fastest_s, fastest = min(ours, key=lambda each: each[0], default=(None, None))
        rows = []
        for row in self.peers:
            if row.preprocessing_s is None or row.inference_s is None:
                continue
            here_s = row.preprocessing_s + row.inference_s
            times = "-" if fastest_s is None else f"{row.inference_s / fastest_s:.0f}"
            rows.append(
                [
                    f"{row.method}, in {row.engine}",
                    _s(row.preprocessing_s),
                    _s(row.inference_s),
                    _s(paper_s[row.method]),
                    f"{here_s / paper_s[row.method]:.2f}",
                    times,
                ]
            )
        ours_name = "our fastest" if fastest is None else fastest.backend.name
        columns = [
            *("network of the shape of", "preprocessing here (s)", "inference here (s)"),
            *("both in the paper (s)", "here / paper", f"inference / that of {ours_name}"),
        ]
        left_out = {row.method: row.leaves_out for row in self.peers}
        lines = (f"- {method}: {what}." for method, what in left_out.items())
        return "\n\n".join(
            [
                "Networks of the peers' shape, with random weights, in float32 on this machine:",
                markdown_table(columns, rows, left=1),
                "What each leaves out:",
                "\n".join(lines),
            ]
        )


def speed_table(
    setting: BackendSetting,
    machine: Machine,
    trials: int,
    presets: Sequence[str] = tuple(PRESETS),
    peers: Sequence[Callable[[], Peer]] = PEERS,
    progress: Callable[[str], None] | None = None,
) -> SpeedTable:
    """Measures our rows, those of one preset in turns, one preset after the other; then the peers.

    Args:
        setting: how the networks are run.
        machine: facts about the machine, from before the run.
        trials: timed frames of each.
        presets: keys of ``PRESETS``.
        peers: make the peers, see ``PEERS``; at most ``PEER_TRIALS`` frames of each.
        progress: called with the name of a row after each of its trials.

    Raises:
        LatencyError: a preset is unknown.
    """
    for preset in presets:
        if preset not in PRESETS:
            raise LatencyError(f"--preset {preset}: choose from {', '.join(PRESETS)}")
    rows: list[OurRow] = []
    for preset in presets:
        rows += _measure_preset(preset, setting, trials, progress)
    beside = time_peers(peers, setting.threads, min(trials, PEER_TRIALS), progress)
    return SpeedTable(tuple(rows), tuple(beside), setting.threads, trials, machine)


def _measure_preset(
    preset: str, setting: BackendSetting, trials: int, progress: Callable[[str], None] | None
) -> list[OurRow]:
    size = PRESETS[preset]
    jpeg = synthetic_jpeg(IMAGE_SIZES[preset])

    def prepare() -> Rgb:
        return preprocess(decode(jpeg, lambda _: enough_for(size)).pixels, size)

    image = prepare()
    found: dict[Backend, LoadedBackend | str] = {}
    for network, engine, precision in OURS:
        backend = Backend(network, size, engine, precision)
        try:
            found[backend] = open_backend(backend, setting)
        except BackendError as error:
            found[backend] = str(error)
    ran = {each: running for each, running in found.items() if not isinstance(running, str)}
    timed = measure(
        {
            "preprocessing": prepare,
            **{each.name: as_frame(running, image) for each, running in ran.items()},
        },
        trials,
        progress=progress,
    )
    preprocessing_s = timed["preprocessing"].summary().p50_ms / 1000
    return [
        OurRow(
            preset,
            each,
            precision=running.precision,
            preprocessing_s=preprocessing_s,
            inference_s=timed[each.name].summary().p50_ms / 1000,
        )
        if not isinstance(running, str)
        else OurRow(preset, each, reason=running)
        for each, running in found.items()
    ]


def _s(seconds: float | None) -> str:
    if seconds is None:
        return "-"
    return f"{seconds:.0f}" if seconds >= 10 else f"{seconds:.3f}"
