"""Cold start: time and memory of fresh processes, from their start until the files are written."""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

from footprints_edge.errors import FootprintsError
from footprints_edge_bench.latency.timing import Ratio, TimingSummary, measure, ratio
from footprints_edge_bench.model_files.synthetic_photos import synthetic_jpeg

PHOTO = (960, 1280)
"""(H, W) of the photo."""

RUN_INFER = """
try:
    from footprints_edge.cli.start import infer
except ImportError:  # a version before that
    from footprints_edge.cli.infer import main as infer
infer()
"""
"""A program: ``fp-infer`` as it is installed, of any version."""

_BASE = "import numpy, onnxruntime, PIL"
_NOTE_MEMORY = """
def peak_bytes():
    try:
        with open("/proc/self/status") as status:
            line = next(line for line in status if line.startswith("VmHWM"))
        return 1024 * int(line.split()[1])
    except (OSError, StopIteration):
        import resource, sys
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (
            1 if sys.platform == "darwin" else 1024)
"""
# VmHWM is the peak of this program alone; ru_maxrss may include the process it was forked from.
_INFER = (
    _NOTE_MEMORY
    + """
import atexit, sys
note = sys.argv.pop(1)
atexit.register(lambda: open(note, "w").write(str(peak_bytes())))
"""
    + RUN_INFER
)
_STEPS = (
    _NOTE_MEMORY
    + """
import json, sys
from time import perf_counter
times = [perf_counter()]
from footprints_edge.model import load
times.append(perf_counter())
model = load(None if sys.argv[1] == "" else sys.argv[1], threads=int(sys.argv[3]))
times.append(perf_counter())
model.predict(sys.argv[2]).ground_depth_m
times.append(perf_counter())
spans = [1000 * (end - start) for start, end in zip(times, times[1:])]
sys.stdout.write(json.dumps([*spans, peak_bytes()]))
"""
)


class ColdStartError(FootprintsError):
    """A fresh process failed."""


@dataclass(frozen=True)
class ColdStart:
    """Measurements of all processes.

    Attributes:
        base: times of a process that only imports numpy, onnxruntime and Pillow.
        infer: times of ``fp-infer`` on one photo, from process start until the file is written.
        infer_against_base: wall time of ``fp-infer`` as a multiple of ``base``.
        cpu_against_base: the same for processor time, which other programs disturb less.
        infer_peak_bytes: peak resident memory of the ``fp-infer`` processes.
        steps_ms: median times of import, load and first frame in a process of their own, by model.
        steps_peak_bytes: peak resident memory of those processes, by model.
    """

    base: TimingSummary
    infer: TimingSummary
    infer_against_base: Ratio
    cpu_against_base: Ratio
    infer_peak_bytes: int
    steps_ms: Mapping[str, Mapping[str, float]]
    steps_peak_bytes: Mapping[str, int]

    def as_markdown(self) -> str:
        """A sentence and a list."""
        found, cpu = self.infer_against_base, self.cpu_against_base
        lines = [
            f"`fp-infer` on one photo, from process start until the file is written: p50 "
            f"{self.infer.p50_ms:.0f} ms, {found.value:.2f} ({found.low:.2f} to {found.high:.2f}) "
            f'times as long as `python -c "{_BASE}"` ({self.base.p50_ms:.0f} ms); '
            f"{cpu.value:.2f} ({cpu.low:.2f} to {cpu.high:.2f}) times its processor time; "
            f"peak memory {self.infer_peak_bytes / 1e6:.0f} MB; {self.infer.n} processes each, in "
            "turns.",
            "",
        ]
        for model, steps in self.steps_ms.items():
            spans = ", ".join(f"{step} {ms:.0f} ms" for step, ms in steps.items())
            peak_mb = self.steps_peak_bytes[model] / 1e6
            lines.append(f"- {model}: {spans}; peak memory {peak_mb:.0f} MB")
        return "\n".join(lines)


def cold_start(models: Mapping[str, str], threads: int, processes: int) -> ColdStart:
    """Times fresh processes in turns.

    Args:
        models: model files or registered names by the names of their rows; "" for the bundled
            model.
        threads: threads of the network.
        processes: number of processes of each kind.

    Raises:
        ColdStartError: a process failed.
    """
    with tempfile.TemporaryDirectory() as folder:
        photo, note = Path(folder, "photo.jpg"), Path(folder, "peak")
        photo.write_bytes(synthetic_jpeg(PHOTO))
        infer = [_INFER, str(note), str(photo), "--overwrite", "--threads", str(threads)]
        peaks_bytes: list[int] = []
        steps: dict[str, list[list[Any]]] = {name: [] for name in models}

        def run_infer() -> None:
            _python(*infer)
            peaks_bytes.append(int(note.read_text()))

        def run_steps(name: str) -> None:
            out = _python(_STEPS, models[name], str(photo), str(threads))
            steps[name].append(json.loads(out))

        timed = measure(
            {
                "base": lambda: _python(_BASE),
                "infer": run_infer,
                **{f"steps {name}": partial(run_steps, name) for name in models},
            },
            processes,
            warm_up=1,  # reads the files into the page cache
            settle_ms=0,
            cpu_clock=_children_cpu_s,
        )
    spans = ("import", "load", "first frame")
    return ColdStart(
        timed["base"].summary(),
        timed["infer"].summary(),
        ratio(timed["infer"].times_ms, timed["base"].times_ms),
        ratio(timed["infer"].cpu_s, timed["base"].cpu_s),
        max(peaks_bytes),
        {
            name: {
                span: median(found[index] for found in steps[name][1:])
                for index, span in enumerate(spans)
            }
            for name in models
        },
        {name: max(found[-1] for found in steps[name]) for name in models},
    )


@dataclass(frozen=True)
class Start:
    """``fp-infer`` on one photo, from process start until the file is written.

    Attributes:
        wall_ms: median time.
        wall: that as a multiple of a process that only imports numpy, onnxruntime and Pillow.
        cpu: the same for processor time, which other programs disturb less.
        peak_bytes: peak resident memory.
    """

    wall_ms: float
    wall: Ratio
    cpu: Ratio
    peak_bytes: int


def start_against_imports(
    runtimes: Mapping[str, Path | None], photo: Path, model: str, threads: int, processes: int
) -> dict[str, Start]:
    """Times the default output of versions of the runtime in turns.

    Args:
        runtimes: checkouts by name; None is the installed runtime.
        photo: the picture.
        model: model file or registered name; empty for each version's bundled model.
        threads: threads of the network.
        processes: number of processes of each kind.

    Raises:
        ColdStartError: a process failed.
    """
    with tempfile.TemporaryDirectory() as folder:
        note = Path(folder, "peak")
        infer = [_INFER, str(note), str(photo), "--overwrite", "--threads", str(threads)]
        infer += ["--model", model] if model else []
        peaks_bytes: dict[str, list[int]] = {name: [] for name in runtimes}

        def run_infer(name: str) -> None:
            _python(*infer, checkout=runtimes[name])
            peaks_bytes[name].append(int(note.read_text()))

        runs = {f"infer {name}": partial(run_infer, name) for name in runtimes}
        timed = measure(
            {"base": lambda: _python(_BASE), **runs},
            processes,
            warm_up=2,  # reads the files into the page cache, keeps bytecode and graph
            settle_ms=0,
            cpu_clock=_children_cpu_s,
        )
    base = timed["base"]
    return {
        name: Start(
            timed[f"infer {name}"].summary().p50_ms,
            ratio(timed[f"infer {name}"].times_ms, base.times_ms),
            ratio(timed[f"infer {name}"].cpu_s, base.cpu_s),
            max(peaks_bytes[name]),
        )
        for name in runtimes
    }


def environment_of(checkout: Path | None) -> dict[str, str]:
    """The environment of a process with the runtime of a checkout; None is the installed one.

    Bytecode is kept, as in every installation, in a folder of its own.
    """
    found = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    found["PYTHONPYCACHEPREFIX"] = str(Path(tempfile.gettempdir(), "fp-bench-bytecode"))
    if checkout is not None:
        found["PYTHONPATH"] = str(checkout / "runtime")
    return found


def _children_cpu_s() -> float:
    """Processor time, seconds, of all finished child processes."""
    times = os.times()
    return times.children_user + times.children_system


def _python(*arguments: str, checkout: Path | None = None) -> str:
    command = [sys.executable, "-c", *arguments]
    done = subprocess.run(
        command, env=environment_of(checkout), capture_output=True, text=True, check=False
    )
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise ColdStartError(f"a fresh process exited with code {done.returncode}: {last}")
    return done.stdout
