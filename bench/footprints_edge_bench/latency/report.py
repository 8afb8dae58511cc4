"""Results of the latency benchmark."""

from dataclasses import dataclass
from typing import Any

from footprints_edge.foundation.types import Size
from footprints_edge_bench.engines.backend import Backend
from footprints_edge_bench.latency.machine import Machine
from footprints_edge_bench.latency.timing import Ratio, TimingSummary
from footprints_edge_bench.model_files.model_cache import REFERENCE

BASELINE = "torch fp32"
"""Ratios in the tables are against the reference network in this engine and precision."""


@dataclass(frozen=True, kw_only=True)
class LatencyRow:
    """Results of one backend.

    Attributes:
        backend: what was requested.
        reason: why it did not run; None if it did.
        precision: precision that it ran in, read back from the engine.
        file_bytes: size of its model files.
        accuracy: difference of its maps from onnxruntime's float32, see
            ``footprints_edge_export.verification.compare.Difference``; None if there is no float32
            file.
        summary: summary of its times.
        times_ms: all times, in the order of the rounds.
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
        """Name of its backend."""
        return self.backend.name


@dataclass(frozen=True, kw_only=True)
class LatencyReport:
    """Results of one run.

    Attributes:
        machine: the machine that it ran on.
        threads: threads for one frame.
        spinning: what onnxruntime's threads did while they waited, see ``Spinning``.
        trials: number of rounds.
        photos: the photos that the maps were compared on, in words.
        rows: in the order of the backends. Rows of one size were timed in turns.
        ratios: for every two rows of one size that ran, the time of the first as a multiple of the
            second.
    """

    machine: Machine
    threads: int
    spinning: str
    trials: int
    photos: str
    rows: tuple[LatencyRow, ...]
    ratios: dict[str, dict[str, Ratio]]

    def failed(self) -> bool:
        """Whether a row of onnxruntime did not run, or none ran. Other engines may be missing."""
        missing = [row for row in self.rows if row.reason is not None]
        ours = any(row.backend.engine == "onnxruntime" for row in missing)
        return ours or len(missing) == len(self.rows)

    def baseline(self, size: Size) -> LatencyRow | None:
        """The row that others of its size are compared with in the tables, if there is one."""
        ran = [row for row in self.rows if row.backend.size == size and row.summary]
        named = f"{REFERENCE} {size[0]}x{size[1]} {BASELINE}"
        return next((row for row in ran if row.name == named), next(iter(ran), None))
