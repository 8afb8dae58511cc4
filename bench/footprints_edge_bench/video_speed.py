"""How fast a whole video goes through, against inference alone, and whether memory stays flat."""

import json
import os
import resource
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from itertools import cycle, islice
from pathlib import Path
from time import perf_counter

from footprints_edge.arrays import Rgb
from footprints_edge.images import DecodedImage
from footprints_edge.model import Model
from footprints_edge.pipeline import Tally, run_pipeline
from footprints_edge.prediction import Prediction
from footprints_edge.tracker import Tracker
from footprints_edge.video import Pace, VideoFile, open_video
from footprints_edge.video_writers import open_sinks, video_paths

_SETTLED = 200
"""Memory is compared with what it was after so many frames."""


@dataclass(frozen=True)
class VideoSpeed:
    """What is measured of one video.

    Attributes:
        frames: how many went through.
        size: (H, W) of them.
        inference_fps: of `Model.predict` on decoded frames, nothing beside it, not even `flatten`.
        pipeline_fps: of `fp-infer VIDEO`: decoding, inference, overlay video and JSON lines.
        smoothed_fps: the same with --smooth.
        early_mb: resident memory after 200 frames of the pipeline, MB.
        late_mb: at the end.
    """

    frames: int
    size: tuple[int, int]
    inference_fps: float
    pipeline_fps: float
    smoothed_fps: float
    early_mb: float
    late_mb: float

    @property
    def share(self) -> float:
        """Of inference's frames a second that the whole reaches."""
        return self.pipeline_fps / self.inference_fps

    def as_json(self) -> str:
        """All figures."""
        return json.dumps({**asdict(self), "share": self.share}, indent=1) + "\n"

    def as_markdown(self) -> str:
        """A small table."""
        height, width = self.size
        rows = {
            "Inference alone": f"{self.inference_fps:.1f}",
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


def measure_video(video: Path, model: Model, frames: int) -> VideoSpeed:
    """Runs a video, over and over until there are so many frames.

    Args:
        video: a file.
        model: to predict with.
        frames: how many; more than 200.
    """
    sample = [
        frame.rgb for frame in islice(open_video(str(video)).frames, 50) if frame.rgb is not None
    ]
    with tempfile.TemporaryDirectory() as folder:
        long = Path(folder) / "long.mp4"
        _repeat(video, long, frames)
        inference_fps = _inference_fps(model, sample)
        memory_mb: list[float] = []

        def note(tally: Tally) -> None:
            if tally.frames % _SETTLED == 0:
                memory_mb.append(_resident_mb())

        plain = _run(long, model, lambda prediction: prediction, Path(folder) / "plain", note)
        smoothed = _run(long, model, Tracker().update, Path(folder) / "smoothed", lambda _: None)
    return VideoSpeed(
        plain.frames,
        (sample[0].shape[0], sample[0].shape[1]),
        inference_fps,
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


def _inference_fps(model: Model, sample: list[Rgb]) -> float:
    for rgb in sample[:5]:
        model.predict(DecodedImage(rgb), flatten=False)
    began_s = perf_counter()
    rounds = 4
    for rgb in sample * rounds:
        model.predict(DecodedImage(rgb), flatten=False)
    return rounds * len(sample) / (perf_counter() - began_s)


def _run(
    video: Path,
    model: Model,
    smooth: Callable[[Prediction], Prediction],
    out: Path,
    progress: Callable[[Tally], None],
) -> Tally:
    opened = open_video(str(video))
    sinks = open_sinks(video_paths(out, video.name, ["overlay", "json"]), opened.fps)
    return run_pipeline(
        opened, lambda rgb: smooth(model.predict(DecodedImage(rgb))), sinks, progress
    )


def _resident_mb() -> float:
    """Resident memory now; where the system does not say, its peak."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
