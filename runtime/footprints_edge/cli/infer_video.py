"""The part of `fp-infer` that reads videos, cameras and pipes."""

import signal
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from footprints_edge.cli.batch import Batch
from footprints_edge.cli.exit_codes import INTERRUPTED, complain
from footprints_edge.cli.progress import ProgressLine
from footprints_edge.errors import FootprintsError, OutputError
from footprints_edge.inputs.images import DecodedImage
from footprints_edge.outputs.writers import refuse_overwriting
from footprints_edge.video.capture import Pace, RawFormat, Video, open_raw, open_video
from footprints_edge.video.pipeline import Tally, run_pipeline
from footprints_edge.video.sinks import open_sinks, video_paths

if TYPE_CHECKING:
    from footprints_edge.model import Camera, Model
    from footprints_edge.prediction import Prediction

_REDRAWN_S = 0.2


@dataclass(frozen=True)
class VideoOptions:
    """How videos are read and what is made of them.

    Attributes:
        pace: Which frames are processed.
        raw: Layout of raw frames on standard input; None means no raw frames.
        smooth: Whether the maps are smoothed over time.
        bev: Whether the overlay has a bird's-eye view beside it.
        formats: Output formats.
        at_once: Frames that are predicted at the same time.
        output: Folder of the outputs; None means beside each file, or here.
        overwrite: Whether existing outputs are replaced.
        quiet: Whether to print results and errors only.
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


def infer_videos(
    named: Sequence[str],
    options: VideoOptions,
    model: "Model",
    camera: "Camera | None",
    threshold: float,
    batch: Batch,
) -> None:
    """Processes one video after the other and prints the files written.

    `model` is best loaded with one thread: `VideoOptions.at_once` keeps the cores busy. Failures
    go to `batch`, as for pictures.
    """
    # a service that is stopped closes its files as one at a terminal does
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    for name in named:
        batch.total += 1
        try:
            interrupted = _infer_video(name, options, model, camera, threshold, batch)
        except (FootprintsError, OSError) as error:
            batch.failures.append(str(error) if name in str(error) else f"{name}: {error}")
            continue
        if interrupted:
            raise typer.Exit(INTERRUPTED)


def _infer_video(
    name: str,
    options: VideoOptions,
    model: "Model",
    camera: "Camera | None",
    threshold: float,
    batch: Batch,
) -> bool:
    """Processes one video; returns whether Ctrl-C ended it."""
    video = open_raw(options.raw, options.pace) if options.raw else open_video(name, options.pace)
    with ExitStack() as stack:
        stack.callback(getattr(video.frames, "close", lambda: None))
        folder = options.output or (video.path.parent if video.path else Path())
        paths = video_paths(folder, video.name, options.formats)
        refuse_overwriting(paths.values(), {video.path.resolve()} if video.path else set())
        kept = [path for path in paths.values() if path.exists() and not options.overwrite]
        if kept and video.path is None:
            raise OutputError(f"its result {kept[0]} is there already; --overwrite replaces it")
        batch.kept += kept
        paths = {key: path for key, path in paths.items() if path not in kept}
        if not paths:
            return False
        sinks = open_sinks(paths, video.fps, bev=options.bev)
        then = _smoother() if options.smooth else None
        stack.pop_all()  # the pipeline closes it
    progress = ProgressLine(shown=not options.quiet, every_s=_REDRAWN_S)
    try:
        tally = run_pipeline(
            video,
            lambda rgb: model.predict(DecodedImage(rgb), intrinsics=camera, threshold=threshold),
            sinks,
            lambda tally: progress.show(_progress_of(video, tally)),
            at_once=options.at_once,
            then=then,
        )
    finally:
        progress.clear()
        for path in paths.values():
            if path.exists():
                typer.echo(path)
    if not options.quiet:
        complain(_line_about(video, tally))
    if not tally.frames and not tally.interrupted:
        raise OutputError(f"{video.name}: no frame of it could be used; {tally.reason or 'empty'}")
    return tally.interrupted


def _smoother() -> "Callable[[Prediction], Prediction]":
    from footprints_edge.video.smoothing import Tracker

    return Tracker().update


def _progress_of(video: Video, tally: Tally) -> str:
    total = f"/{video.total}" if video.total else ""
    line = f"{video.name}  {tally.frames}{total} frames, {tally.fps:.1f} a second"
    if tally.dropped:
        line += f", {tally.dropped} dropped"
    if tally.broken:
        line += f", {tally.broken} broken"
    return line


def _line_about(video: Video, tally: Tally) -> str:
    line = f"{video.name}: {tally.frames} frames, {tally.fps:.1f} a second"
    if tally.dropped:
        line += f", {tally.dropped} dropped to keep up"
    if tally.broken:
        line += f", {tally.broken} broken ({tally.reason})"
    return line
