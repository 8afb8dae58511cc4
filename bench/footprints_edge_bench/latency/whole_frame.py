"""What a frame costs beside what its network costs: arrays, phone photos, a start, and folders.

Several versions of the runtime can be measured in turns, each from its checkout.
"""

import random
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import perf_counter

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.types import Rgb, Size
from footprints_edge_bench.foundation.markdown import markdown_table
from footprints_edge_bench.latency.cold_start import (
    RUN_INFER,
    Start,
    environment_of,
    start_against_imports,
)
from footprints_edge_bench.latency.end_to_end import PHONE
from footprints_edge_bench.latency.timing import Ratio, ratio
from footprints_edge_bench.model_files.synthetic_photos import enlarged_jpeg

FRAME: Size = (720, 1280)
"""(H, W) of the array, and of the photos of the folder."""

STEPS = ("network", "array", "result", "draft", "jpeg")


class WholeFrameError(FootprintsError):
    """A runtime that was to be measured failed."""


@dataclass(frozen=True)
class WholeFrame:
    """Medians, in ms, and ratios of one run in turns.

    Attributes:
        network_ms: the network alone, at the array's input size.
        array_ms: ``predict`` on an array.
        resize_ms: the resize in that.
        result_ms: masks, plane, flattened and masked depth of a prediction.
        draft_ms: decoding the phone's JPEG at a reduced size of at least twice the input, alone.
        jpeg_ms: from the phone's JPEG to the ground's depth in metres.
        array_against_network: ratio of those two.
        jpeg_against_draft: ratio of those two.
        start: ``fp-infer`` on one photo, against bare imports.
        folder_fps: photos a second of ``fp-infer FOLDER --format json``, its start included.
    """

    network_ms: float
    array_ms: float
    resize_ms: float
    result_ms: float
    draft_ms: float
    jpeg_ms: float
    array_against_network: Ratio
    jpeg_against_draft: Ratio
    start: Start
    folder_fps: float


def whole_frame(
    runtimes: Mapping[str, Path | None],
    photo: Rgb,
    model: str,
    *,
    threads: int,
    trials: int,
    starts: int,
    photos: int,
) -> dict[str, WholeFrame]:
    """Measures versions of the runtime in turns.

    Args:
        runtimes: checkouts by the names of their columns; None is the installed runtime.
        photo: uint8 (h, w, 3), enlarged to the sizes of frame and phone; one that shows ground, as
            the result of others takes no time.
        model: model file or registered name; empty for each version's bundled model.
        threads: threads of the network.
        trials: timed frames of each kind.
        starts: fresh processes of each kind.
        photos: photos in the folder; 0 leaves the folder out.

    Raises:
        WholeFrameError: a runtime failed.
    """
    with tempfile.TemporaryDirectory() as folder:
        frame, phone = Path(folder, "frame.jpg"), Path(folder, "phone.jpg")
        frame.write_bytes(enlarged_jpeg(photo, FRAME))
        phone.write_bytes(enlarged_jpeg(photo, PHONE))
        arguments = [str(frame), str(phone), str(threads), model]
        times_ms, resize_ms = _steps(runtimes, arguments, trials)
        start = start_against_imports(runtimes, frame, model, threads, starts)
        fps = {
            name: _folder_fps(checkout, frame, model, threads, photos) if photos else float("nan")
            for name, checkout in runtimes.items()
        }
    found = {}
    for name in runtimes:
        of = times_ms[name]
        medians = {f"{step}_ms": median(of[step]) for step in STEPS}
        found[name] = WholeFrame(
            **medians,
            resize_ms=median(resize_ms[name]),
            array_against_network=ratio(of["array"], of["network"]),
            jpeg_against_draft=ratio(of["jpeg"], of["draft"]),
            start=start[name],
            folder_fps=fps[name],
        )
    return found


def as_markdown(found: Mapping[str, WholeFrame]) -> str:
    """A table with a column for each runtime."""
    rows: list[tuple[str, Callable[[WholeFrame], str]]] = [
        ("network alone, ms", lambda each: f"{each.network_ms:.1f}"),
        (
            f"`predict` on an array of {FRAME[1]}x{FRAME[0]}, ms",
            lambda each: f"{each.array_ms:.1f}",
        ),
        ("its resize, ms", lambda each: f"{each.resize_ms:.1f}"),
        ("`predict` / network", lambda each: _text(each.array_against_network)),
        ("masks, plane, flattened depth, ms", lambda each: f"{each.result_ms:.1f}"),
        (
            f"draft decode of a JPEG of {PHONE[1]}x{PHONE[0]}, ms",
            lambda each: f"{each.draft_ms:.1f}",
        ),
        ("that JPEG to metres, ms", lambda each: f"{each.jpeg_ms:.1f}"),
        ("that / draft decode", lambda each: _text(each.jpeg_against_draft)),
        ("`fp-infer` on a photo, ms", lambda each: f"{each.start.wall_ms:.0f}"),
        ("that / bare imports", lambda each: _text(each.start.wall)),
        ("the same in processor time", lambda each: _text(each.start.cpu)),
        ("its peak memory, MB", lambda each: f"{each.start.peak_bytes / 1e6:.0f}"),
        ("`fp-infer` on a folder, photos a second", lambda each: f"{each.folder_fps:.1f}"),
        (
            "that / rate of the network",
            lambda each: f"{each.folder_fps * each.network_ms / 1000:.2f}",
        ),
    ]
    lines = [[name, *map(text, found.values())] for name, text in rows]
    return markdown_table(["", *found], lines) + "\n"


def _text(found: Ratio) -> str:
    return f"{found.value:.2f} ({found.low:.2f} to {found.high:.2f})"


def _steps(
    runtimes: Mapping[str, Path | None], arguments: Sequence[str], trials: int
) -> tuple[dict[str, dict[str, list[float]]], dict[str, list[float]]]:
    """Times by runtime and step, and those of the array's resize by runtime, in ms."""
    times_ms: dict[str, dict[str, list[float]]] = {
        name: {step: [] for step in STEPS} for name in runtimes
    }
    resize_ms: dict[str, list[float]] = {name: [] for name in runtimes}
    turns = [(name, step) for name in runtimes for step in STEPS]
    order = random.Random(0)
    with ExitStack() as stack:
        ask = {
            name: stack.enter_context(_Asked(checkout, arguments))
            for name, checkout in runtimes.items()
        }
        for _ in range(trials):
            for name, step in order.sample(turns, len(turns)):
                took, resize = ask[name].ms(step)
                times_ms[name][step].append(took)
                if step == "array":
                    resize_ms[name].append(resize)
    return times_ms, resize_ms


class _Asked:
    """A process of `frame_steps` with one runtime."""

    def __init__(self, checkout: Path | None, arguments: Sequence[str]) -> None:
        program = Path(__file__).with_name("frame_steps.py").read_text(encoding="utf-8")
        self._process = subprocess.Popen(
            [sys.executable, "-c", program, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=environment_of(checkout),
            text=True,
        )

    def __enter__(self) -> "_Asked":
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.communicate()

    def ms(self, step: str) -> tuple[float, float]:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(f"{step}\n")
            self._process.stdin.flush()
            took, resize = map(float, self._process.stdout.readline().split())
        except (OSError, ValueError):
            raise WholeFrameError("a runtime that is measured has ended; see above why") from None
        return took, resize


def _folder_fps(checkout: Path | None, photo: Path, model: str, threads: int, photos: int) -> float:
    with tempfile.TemporaryDirectory() as folder:
        for number in range(photos):
            Path(folder, f"{number}.jpg").write_bytes(photo.read_bytes())
        command = [sys.executable, "-c", RUN_INFER, folder, "-q"]
        command += ["--format", "json", "--threads", str(threads)]
        command += ["--model", model] if model else []
        start_s = perf_counter()
        done = subprocess.run(
            command, env=environment_of(checkout), capture_output=True, text=True, check=False
        )
        took_s = perf_counter() - start_s
    if done.returncode:
        raise WholeFrameError(f"fp-infer exited with code {done.returncode}: {done.stderr.strip()}")
    return photos / took_s
