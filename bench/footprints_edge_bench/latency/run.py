"""The whole latency benchmark: networks, whole frames, cold start, and the files it writes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.model import load
from footprints_edge_bench.engines.backend import Backend, BackendSetting
from footprints_edge_bench.latency.benchmark import time_backends
from footprints_edge_bench.latency.cold_start import ColdStart, cold_start
from footprints_edge_bench.latency.end_to_end import EndToEnd, end_to_end
from footprints_edge_bench.latency.machine import machine
from footprints_edge_bench.latency.plot import draw
from footprints_edge_bench.latency.report import LatencyReport
from footprints_edge_bench.latency.tables import as_json, as_markdown


@dataclass(frozen=True)
class LatencyRun:
    """Results of the whole benchmark.

    Attributes:
        networks: networks alone.
        frames: whole frames, by model; empty if they were left out.
        cold: cold start; None if it was left out.
    """

    networks: LatencyReport
    frames: Sequence[EndToEnd]
    cold: ColdStart | None

    def write(self, folder: Path) -> str:
        """Writes ``latency.md``, ``latency.json`` and ``latency.png``.

        Args:
            folder: an existing folder.

        Returns:
            The Markdown.
        """
        markdown = as_markdown(self.networks, self.frames, self.cold)
        (folder / "latency.md").write_text(markdown, encoding="utf-8")
        (folder / "latency.json").write_text(
            as_json(self.networks, self.frames, self.cold), encoding="utf-8"
        )
        draw(self.networks, folder / "latency.png")
        return markdown


def run_latency(
    backends: Sequence[Backend],
    setting: BackendSetting,
    trials: int,
    *,
    models: Sequence[str],
    photos: Mapping[Size, Sequence[Rgb]] | None,
    processes: int,
    network_only: bool,
    progress: Callable[[str], None] | None = None,
) -> LatencyRun:
    """Measures networks alone, then whole frames and the cold start of models.

    Args:
        backends: networks to measure alone.
        setting: how they are run.
        trials: timed frames of each.
        models: model files whose frames and cold start are measured beside the bundled model's.
        photos: photos to compare maps on, see :func:`time_backends`.
        processes: fresh processes for the cold start; 0 leaves it out.
        network_only: whether to leave out whole frames and the cold start.
        progress: called with the name of a backend after each of its trials.
    """
    networks = time_backends(backends, setting, machine(), trials, photos, progress)
    if network_only:
        return LatencyRun(networks, (), None)
    files = {"edge int8": ""} | {name: name for name in models}
    loaded = {row: load(file or None, threads=setting.threads) for row, file in files.items()}
    frames = end_to_end(loaded, trials)
    cold = cold_start(files, setting.threads, processes) if processes else None
    return LatencyRun(networks, frames, cold)
