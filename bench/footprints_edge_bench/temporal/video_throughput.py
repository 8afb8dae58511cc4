"""Video throughput against inference alone, and whether memory stays constant."""

import json
import os
import resource
import tempfile
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from itertools import cycle, islice
from pathlib import Path
from statistics import median
from time import perf_counter

from footprints_edge.foundation.types import Rgb
from footprints_edge.inputs.images import DecodedImage
from footprints_edge.model import Model, load
from footprints_edge.prediction import Prediction
from footprints_edge.video.capture import Pace, open_video
from footprints_edge.video.file import VideoFile
from footprints_edge.video.pipeline import run_pipeline
from footprints_edge.video.sinks import open_sinks, video_paths
from footprints_edge.video.smoothing import Tracker
from footprints_edge_bench.foundation.markdown import markdown_table

ROUNDS = 4
"""Each kind runs this many times, in turns: other work on the machine hits all kinds alike."""

_SAMPLE_FRAMES = 50

INFERENCE, AT_ONCE = "Inference alone, frame by frame", "Inference alone, frames in parallel"
PLAIN = "fp-infer VIDEO"
SMOOTHED, PANEL, LINES = f"{PLAIN} --smooth", f"{PLAIN} --panel", f"{PLAIN} --format overlay,json"


@dataclass(frozen=True)
class VideoSpeed:
    """Measurements of one video.

    Attributes:
        frames: number of frames that each kind of pipeline processed.
        size: (H, W) of the frames.
        fps: frames per second of each kind, in each of its rounds. Inference is `Model.predict` on
            decoded frames without `flatten`, with nothing else running: one frame after the other
            on all threads, or as many at once as there are threads, on one thread each. The
            pipelines decode, predict, draw and encode as the command does.
        early_mb: resident memory after the first round of the plain pipeline, MB.
        late_mb: resident memory after its last round, MB.
    """

    frames: int
    size: tuple[int, int]
    fps: dict[str, tuple[float, ...]]
    early_mb: float
    late_mb: float

    def share(self, kind: str, of: str) -> float:
        """Throughput of one kind as a share of another's: the median over the rounds."""
        pairs = zip(self.fps[kind], self.fps[of], strict=True)
        return median(fps / other for fps, other in pairs)

    def as_json(self) -> str:
        """All values."""
        return json.dumps(asdict(self), indent=1) + "\n"

    def as_markdown(self) -> str:
        """A table and the memory."""
        height, width = self.size
        rows = [
            [
                kind,
                f"{median(fps):.1f}",
                *(f"{self.share(kind, of):.2f}" for of in (INFERENCE, AT_ONCE, PLAIN)),
            ]
            for kind, fps in self.fps.items()
        ]
        columns = ["", "frames per second", *("/ frame by frame", "/ in parallel", f"/ {PLAIN}")]
        return (
            f"## Video: {self.frames} frames of {width} x {height}\n\n"
            f"{markdown_table(columns, rows)}\n\n"
            f"Medians of {ROUNDS} rounds in turns. Memory: {self.early_mb:.0f} MB after "
            f"{self.frames // ROUNDS} frames, {self.late_mb:.0f} MB at the end.\n"
        )


def measure_video(video: Path, model: str | None, threads: int, frames: int) -> VideoSpeed:
    """Processes a video, repeated until there are enough frames.

    Args:
        video: a video file.
        model: a model file or a registered name; None for the bundled model.
        threads: number of threads; `fp-infer` predicts as many frames at once, on one thread each.
        frames: number of frames for each kind of pipeline, over all rounds.
    """
    sample = [
        frame.rgb
        for frame in islice(open_video(str(video)).frames, _SAMPLE_FRAMES)
        if frame.rgb is not None
    ]
    all_threads, one_thread = load(model, threads=threads), load(model, threads=1)
    memory_mb: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        repeated = Path(folder) / "long.mp4"
        _repeat(video, repeated, frames // ROUNDS)

        def pipeline(
            *formats: str, then: Callable[[Prediction], Prediction] | None = None, bev: bool = False
        ) -> float:
            with tempfile.TemporaryDirectory(dir=folder) as out:
                return _process(repeated, Path(out), one_thread, threads, formats, then, bev=bev)

        kinds: dict[str, Callable[[], float]] = {
            INFERENCE: lambda: _inference_fps(all_threads, sample, at_once=1),
            AT_ONCE: lambda: _inference_fps(one_thread, sample, at_once=threads),
            PLAIN: lambda: pipeline("overlay"),
            SMOOTHED: lambda: pipeline("overlay", then=Tracker().update),
            PANEL: lambda: pipeline("overlay", bev=True),
            LINES: lambda: pipeline("overlay", "json"),
        }
        fps: dict[str, list[float]] = {kind: [] for kind in kinds}
        for _ in range(ROUNDS):
            for kind, measure in kinds.items():
                fps[kind].append(measure())
                if kind == PLAIN:
                    memory_mb.append(_resident_mb())
    return VideoSpeed(
        frames=frames // ROUNDS * ROUNDS,
        size=(sample[0].shape[0], sample[0].shape[1]),
        fps={kind: tuple(values) for kind, values in fps.items()},
        early_mb=memory_mb[0],
        late_mb=memory_mb[-1],
    )


def _process(
    video: Path,
    out: Path,
    model: Model,
    at_once: int,
    formats: Sequence[str],
    then: Callable[[Prediction], Prediction] | None,
    *,
    bev: bool,
) -> float:
    """Frames per second of the pipeline of `fp-infer VIDEO`, its start and end included."""
    opened = open_video(str(video))
    stats = run_pipeline(
        opened,
        lambda frame: model.predict(frame.image),
        open_sinks(video_paths(out, video.name, formats), opened.fps, bev=bev),
        at_once=at_once,
        then=then,
    )
    return stats.fps


def _repeat(video: Path, out: Path, frames: int) -> None:
    """Writes a video with this number of frames by repeating the given one."""
    file = VideoFile(out, 30.0)
    for rgb in islice(_endless(video), frames):
        file.write(rgb[..., ::-1].copy())
    file.close()


def _endless(video: Path) -> Iterator[Rgb]:
    for name in cycle([str(video)]):
        for frame in open_video(name, Pace()).frames:
            if frame.rgb is not None:
                yield frame.rgb


def _inference_fps(model: Model, sample: Sequence[Rgb], at_once: int) -> float:
    def predict(rgb: Rgb) -> Prediction:
        return model.predict(DecodedImage(rgb), flatten=False)

    with ThreadPoolExecutor(at_once) as pool:
        deque(pool.map(predict, sample[:5]), maxlen=0)
        start_s = perf_counter()
        deque(pool.map(predict, sample), maxlen=0)
        return len(sample) / (perf_counter() - start_s)


def _resident_mb() -> float:
    """Resident memory; its peak where the system does not report the current value."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
