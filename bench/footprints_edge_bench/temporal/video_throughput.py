"""How fast a whole video goes through, against inference alone, and whether memory stays flat."""

import json
import os
import resource
import tempfile
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from itertools import cycle, islice
from pathlib import Path
from time import perf_counter

from footprints_edge.foundation.types import Rgb
from footprints_edge.inputs.images import DecodedImage
from footprints_edge.model import Model, load
from footprints_edge.prediction import Prediction
from footprints_edge.video.capture import Pace, VideoFile, open_video
from footprints_edge.video.pipeline import VideoStats, run_pipeline
from footprints_edge.video.sinks import open_sinks, video_paths
from footprints_edge.video.smoothing import Tracker

_SETTLED = 200
"""Memory is compared with what it was after so many frames."""


@dataclass(frozen=True)
class VideoSpeed:
    """What is measured of one video.

    Attributes:
        frames: how many went through.
        size: (H, W) of them.
        inference_fps: of `Model.predict` on decoded frames, one after the other on all threads,
            nothing beside it, not even `flatten`.
        inference_at_once_fps: likewise, of as many frames at once as threads, on one each.
        pipeline_fps: of `fp-infer VIDEO`: decoding, inference, overlay video and JSON lines.
        smoothed_fps: the same with --smooth.
        early_mb: resident memory after 200 frames of the pipeline, MB.
        late_mb: at the end.
    """

    frames: int
    size: tuple[int, int]
    inference_fps: float
    inference_at_once_fps: float
    pipeline_fps: float
    smoothed_fps: float
    early_mb: float
    late_mb: float

    @property
    def share(self) -> float:
        """Of inference's frames a second, frame by frame, that the whole reaches."""
        return self.pipeline_fps / self.inference_fps

    def as_json(self) -> str:
        """All figures."""
        return json.dumps({**asdict(self), "share": self.share}, indent=1) + "\n"

    def as_markdown(self) -> str:
        """A small table."""
        height, width = self.size
        rows = {
            "Inference alone, frame by frame": f"{self.inference_fps:.1f}",
            "Inference alone, frames at once": f"{self.inference_at_once_fps:.1f}",
            "fp-infer VIDEO": f"{self.pipeline_fps:.1f} ({self.share:.0%})",
            "fp-infer VIDEO --smooth": f"{self.smoothed_fps:.1f}",
        }
        return "\n".join(
            [
                f"## Video: {self.frames} frames of {width} x {height}",
                "",
                "| | frames a second |",
                "| --- | ---: |",
                *(f"| {name} | {fps} |" for name, fps in rows.items()),
                "",
                f"Memory: {self.early_mb:.0f} MB after {_SETTLED} frames, {self.late_mb:.0f} MB at "
                "the end.",
                "",
            ]
        )


def measure_video(video: Path, model: str | None, threads: int, frames: int) -> VideoSpeed:
    """Runs a video, over and over until there are so many frames.

    Args:
        video: a file.
        model: a file or a registered name; None for the bundled one.
        threads: to use; `fp-infer` predicts so many frames at once, on one thread each.
        frames: how many; more than 200.
    """
    sample = [
        frame.rgb for frame in islice(open_video(str(video)).frames, 50) if frame.rgb is not None
    ]
    inference_fps = _inference_fps(load(model, threads=threads), sample, at_once=1)
    one_thread = load(model, threads=1)
    at_once_fps = _inference_fps(one_thread, sample, at_once=threads)
    with tempfile.TemporaryDirectory() as folder:
        long = Path(folder) / "long.mp4"
        _repeat(video, long, frames)
        memory_mb: list[float] = []

        def note(tally: VideoStats) -> None:
            if tally.frames % _SETTLED == 0:
                memory_mb.append(_resident_mb())

        def run(
            name: str,
            then: Callable[[Prediction], Prediction] | None,
            told: Callable[[VideoStats], None],
        ) -> VideoStats:
            opened = open_video(str(long))
            paths = video_paths(Path(folder) / name, long.name, ["overlay", "json"])
            return run_pipeline(
                opened,
                lambda rgb: one_thread.predict(DecodedImage(rgb)),
                open_sinks(paths, opened.fps),
                told,
                at_once=threads,
                then=then,
            )

        plain = run("plain", None, note)
        smoothed = run("smoothed", Tracker().update, lambda _: None)
    return VideoSpeed(
        plain.frames,
        (sample[0].shape[0], sample[0].shape[1]),
        inference_fps,
        at_once_fps,
        plain.fps,
        smoothed.fps,
        memory_mb[0],
        memory_mb[-1],
    )


def _repeat(video: Path, out: Path, frames: int) -> None:
    """Writes a video of so many frames: the given one, again and again."""
    file = VideoFile(out, 30.0)
    for rgb in islice(_again_and_again(video), frames):
        file.write(rgb[..., ::-1].copy())
    file.close()


def _again_and_again(video: Path) -> Iterator[Rgb]:
    for name in cycle([str(video)]):
        for frame in open_video(name, Pace()).frames:
            if frame.rgb is not None:
                yield frame.rgb


def _inference_fps(model: Model, sample: list[Rgb], at_once: int) -> float:
    def predict(rgb: Rgb) -> Prediction:
        return model.predict(DecodedImage(rgb), flatten=False)

    rounds = 4
    with ThreadPoolExecutor(at_once) as pool:
        deque(pool.map(predict, sample[:5]), maxlen=0)
        began_s = perf_counter()
        deque(pool.map(predict, sample * rounds), maxlen=0)
        return rounds * len(sample) / (perf_counter() - began_s)


def _resident_mb() -> float:
    """Resident memory now; where the system does not say, its peak."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
