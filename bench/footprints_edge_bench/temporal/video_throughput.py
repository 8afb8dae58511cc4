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
from time import perf_counter

from footprints_edge.foundation.types import Rgb
from footprints_edge.inputs.images import DecodedImage
from footprints_edge.model import Model, load
from footprints_edge.prediction import Prediction
from footprints_edge.video.capture import Pace, open_video
from footprints_edge.video.file import VideoFile
from footprints_edge.video.pipeline import VideoStats, run_pipeline
from footprints_edge.video.sinks import open_sinks, video_paths
from footprints_edge.video.smoothing import Tracker
from footprints_edge_bench.foundation.markdown import markdown_table

SETTLED_FRAMES = 200
"""Memory is compared with its value after this number of frames."""

_SAMPLE_FRAMES = 50


@dataclass(frozen=True)
class VideoSpeed:
    """Measurements of one video.

    Attributes:
        frames: number of frames that were processed.
        size: (H, W) of the frames.
        inference_fps: frames per second of `Model.predict` on decoded frames, one after the other
            on all threads, with nothing else running and without `flatten`.
        inference_at_once_fps: the same with as many frames at once as there are threads, on one
            thread each.
        pipeline_fps: frames per second of `fp-infer VIDEO`: decoding, inference, overlay video and
            JSON lines.
        smoothed_fps: the same with --smooth.
        panel_fps: the same with --panel.
        early_mb: resident memory after 200 frames of the pipeline, MB.
        late_mb: resident memory at the end, MB.
    """

    frames: int
    size: tuple[int, int]
    inference_fps: float
    inference_at_once_fps: float
    pipeline_fps: float
    smoothed_fps: float
    panel_fps: float
    early_mb: float
    late_mb: float

    @property
    def share(self) -> float:
        """Throughput of the pipeline as a share of frame-by-frame inference."""
        return self.pipeline_fps / self.inference_fps

    def _against_plain(self, fps: float) -> str:
        return f"{fps:.1f} ({fps / self.pipeline_fps - 1:+.0%})"

    def as_json(self) -> str:
        """All values."""
        return json.dumps({**asdict(self), "share": self.share}, indent=1) + "\n"

    def as_markdown(self) -> str:
        """A table and the memory."""
        height, width = self.size
        rows = [
            ["Inference alone, frame by frame", f"{self.inference_fps:.1f}"],
            ["Inference alone, frames in parallel", f"{self.inference_at_once_fps:.1f}"],
            ["fp-infer VIDEO", f"{self.pipeline_fps:.1f} ({self.share:.0%})"],
            ["fp-infer VIDEO --smooth", self._against_plain(self.smoothed_fps)],
            ["fp-infer VIDEO --panel", self._against_plain(self.panel_fps)],
        ]
        return (
            f"## Video: {self.frames} frames of {width} x {height}\n\n"
            f"{markdown_table(['', 'frames per second'], rows)}\n\n"
            f"Memory: {self.early_mb:.0f} MB after {SETTLED_FRAMES} frames, {self.late_mb:.0f} MB "
            "at the end.\n"
        )


def measure_video(video: Path, model: str | None, threads: int, frames: int) -> VideoSpeed:
    """Processes a video, repeated until there are enough frames.

    Args:
        video: a video file.
        model: a model file or a registered name; None for the bundled model.
        threads: number of threads; `fp-infer` predicts as many frames at once, on one thread each.
        frames: number of frames; at least 200.
    """
    sample = [
        frame.rgb
        for frame in islice(open_video(str(video)).frames, _SAMPLE_FRAMES)
        if frame.rgb is not None
    ]
    inference_fps = _inference_fps(load(model, threads=threads), sample, at_once=1)
    one_thread = load(model, threads=1)
    at_once_fps = _inference_fps(one_thread, sample, at_once=threads)
    with tempfile.TemporaryDirectory() as folder:
        repeated = Path(folder) / "long.mp4"
        _repeat(video, repeated, frames)
        memory_mb: list[float] = []

        def note_memory(stats: VideoStats) -> None:
            if stats.frames % SETTLED_FRAMES == 0:
                memory_mb.append(_resident_mb())

        def run(
            name: str,
            then: Callable[[Prediction], Prediction] | None = None,
            progress: Callable[[VideoStats], None] = lambda _: None,
            *,
            bev: bool = False,
        ) -> VideoStats:
            out = Path(folder) / name
            return _process(repeated, out, one_thread, threads, then, progress, bev=bev)

        plain = run("plain", progress=note_memory)
        smoothed = run("smoothed", Tracker().update)
        panel = run("panel", bev=True)
    return VideoSpeed(
        frames=plain.frames,
        size=(sample[0].shape[0], sample[0].shape[1]),
        inference_fps=inference_fps,
        inference_at_once_fps=at_once_fps,
        pipeline_fps=plain.fps,
        smoothed_fps=smoothed.fps,
        panel_fps=panel.fps,
        early_mb=memory_mb[0],
        late_mb=memory_mb[-1],
    )


def _process(
    video: Path,
    out: Path,
    model: Model,
    at_once: int,
    then: Callable[[Prediction], Prediction] | None,
    progress: Callable[[VideoStats], None],
    *,
    bev: bool,
) -> VideoStats:
    """Runs the pipeline of `fp-infer VIDEO`."""
    opened = open_video(str(video))
    paths = video_paths(out, video.name, ["overlay", "json"])
    return run_pipeline(
        opened,
        lambda frame: model.predict(frame.image),
        open_sinks(paths, opened.fps, bev=bev),
        progress,
        at_once=at_once,
        then=then,
    )


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

    rounds = 4
    with ThreadPoolExecutor(at_once) as pool:
        deque(pool.map(predict, sample[:5]), maxlen=0)
        start_s = perf_counter()
        deque(pool.map(predict, [*sample] * rounds), maxlen=0)
        return rounds * len(sample) / (perf_counter() - start_s)


def _resident_mb() -> float:
    """Resident memory; its peak where the system does not report the current value."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
