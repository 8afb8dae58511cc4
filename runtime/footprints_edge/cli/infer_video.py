"""The part of `fp-infer` for videos, cameras and pipes."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from footprints_edge.cli.batch import Batch
from footprints_edge.cli.camera_options import lens_warning
from footprints_edge.cli.exit_codes import INTERRUPTED, complain, name_file
from footprints_edge.cli.progress import ProgressLine
from footprints_edge.errors import OutputError
from footprints_edge.foundation.addresses import without_password
from footprints_edge.foundation.real_path import real_path
from footprints_edge.inputs.images import DecodedImage
from footprints_edge.outputs.writers import refuse_overwriting
from footprints_edge.video.capture import Pace, RawFormat, Video, open_raw, open_video
from footprints_edge.video.pipeline import VideoStats, run_pipeline
from footprints_edge.video.sinks import open_sinks, video_paths

if TYPE_CHECKING:
    from footprints_edge.prediction import Prediction

REDRAW_S = 0.2
"""Least time between two progress lines."""


@dataclass(frozen=True)
class VideoOptions:
    """Options for reading videos and writing their results.

    Attributes:
        pace: Which frames to process.
        raw: Layout of raw frames on standard input; None means no raw frames.
        smooth: Whether to smooth the maps over time.
        bev: Whether to add a bird's-eye view beside the overlay.
        formats: Output formats.
        at_once: Number of frames to predict in parallel.
        output: Folder of the outputs; None means beside each file, or the current folder.
        overwrite: Whether to replace existing outputs.
        quiet: Whether to print results and errors only.
        lens_assumed: Whether nothing is known of the lens: frames have no EXIF.
    """

    pace: Pace
    raw: RawFormat | None
    smooth: bool
    bev: bool
    formats: Sequence[str]
    at_once: int
    output: Path | None
    overwrite: bool
    quiet: bool
    lens_assumed: bool = False


def infer_videos(
    named: Sequence[str],
    options: VideoOptions,
    predict: "Callable[[DecodedImage], Prediction]",
    batch: Batch,
) -> None:
    """Processes the videos in order and prints the files written.

    `VideoOptions.at_once` keeps the cores busy, so the model is best loaded with one thread.
    Failures are added to `batch`, as for pictures.
    """
    warning = lens_warning("assumed") if options.lens_assumed and not options.quiet else ""
    for name in named:
        batch.total += 1
        try:
            interrupted = _infer_video(name, options, predict, batch)
        except Exception as error:  # no error may stop the other videos
            batch.failed(without_password(name), error)
            continue
        if warning:
            complain(warning)
            warning = ""
        if interrupted:
            raise SystemExit(INTERRUPTED)


def _infer_video(
    name: str,
    options: VideoOptions,
    predict: "Callable[[DecodedImage], Prediction]",
    batch: Batch,
) -> bool:
    """Processes one video; returns whether Ctrl-C ended it."""
    video = open_raw(options.raw, options.pace) if options.raw else open_video(name, options.pace)
    with ExitStack() as stack:
        stack.callback(getattr(video.frames, "close", lambda: None))
        folder = options.output or (video.path.parent if video.path else Path())
        paths = video_paths(folder, video.name, options.formats)
        refuse_overwriting(paths.values(), {real_path(video.path)} if video.path else set())
        kept = [path for path in paths.values() if path.exists() and not options.overwrite]
        if kept and video.path is None:
            raise OutputError(f"its result {kept[0]} already exists; --overwrite replaces it")
        batch.kept += kept
        paths = {key: path for key, path in paths.items() if path not in kept}
        if not paths:
            return False
        sinks = open_sinks(paths, video.fps, bev=options.bev, endless=video.path is None)
        then = smoother() if options.smooth else None
        stack.pop_all()  # the pipeline closes it
    progress = ProgressLine(shown=not options.quiet, every_s=REDRAW_S)
    try:
        stats = run_pipeline(
            video,
            lambda frame: predict(frame.image),
            sinks,
            lambda stats: progress.show(progress_text(video, stats)),
            at_once=options.at_once,
            then=then,
        )
    finally:
        progress.clear()
        for sink in sinks:
            if sink.written is not None:
                name_file(sink.written)
    if not options.quiet:
        complain(summary_line(video, stats))
    if not stats.frames and not stats.interrupted:
        raise OutputError(f"{video.name} has no usable frame; {stats.reason or 'it is empty'}")
    return stats.interrupted


def smoother() -> "Callable[[Prediction], Prediction]":
    """What smooths the predictions of one video, in order."""
    from footprints_edge.video.smoothing import Tracker

    return Tracker().update


def progress_text(video: Video, stats: VideoStats) -> str:
    """The progress line of a video under way."""
    total = f"/{video.total}" if video.total else ""
    line = f"{video.name}  {stats.frames}{total} frames, {stats.fps:.1f} fps"
    if stats.dropped:
        line += f", {stats.dropped} dropped"
    if stats.broken:
        line += f", {stats.broken} broken"
    return line


def summary_line(video: Video, stats: VideoStats) -> str:
    """What is said of a video at its end."""
    line = f"{video.name}: {stats.frames} frames, {stats.fps:.1f} fps"
    if stats.dropped:
        line += f", {stats.dropped} dropped to keep up"
    if stats.broken:
        line += f", {stats.broken} broken ({stats.reason})"
    return line
