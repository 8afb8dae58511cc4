"""The part of `fp-infer` for bags of ROS."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from footprints_edge.cli.batch import Batch
from footprints_edge.cli.camera_options import CameraOptions, lens_warning
from footprints_edge.cli.exit_codes import INTERRUPTED, complain, name_file
from footprints_edge.cli.infer_video import REDRAW_S, progress_text, smoother, summary_line
from footprints_edge.cli.progress import ProgressLine
from footprints_edge.errors import BagError, FootprintsError, OutputError
from footprints_edge.foundation.addresses import is_address, without_password
from footprints_edge.foundation.cores import usable_cores
from footprints_edge.foundation.real_path import real_path
from footprints_edge.model import Camera, load
from footprints_edge.outputs.writers import refuse_overwriting
from footprints_edge.ros.bag_names import partial_bag, written_bag
from footprints_edge.ros.bag_sink import BagSink
from footprints_edge.ros.bag_source import BagFrame, Topics, message_name, open_bag
from footprints_edge.ros.ground_messages import GroundOutput
from footprints_edge.video.capture import Pace, Video, VideoFrame
from footprints_edge.video.pipeline import run_pipeline

if TYPE_CHECKING:
    from footprints_edge.prediction import Prediction

_MOST_NAMED = 20
"""Bad messages that are named one by one."""


@dataclass(frozen=True)
class BagOptions:
    """Options for reading bags and writing theirs.

    Attributes:
        every: Process every Nth picture.
        max_fps: Maximum number of pictures per second of recording; None means no limit.
        topic: Topic of the pictures; None if a bag has one camera.
        camera: The camera of the options, which comes before `CameraInfo`.
        content: What is written.
        bev: Whether overlays have a bird's-eye view beside them.
        smooth: Whether to smooth the maps over time.
        threads: Number of pictures to predict in parallel; None means one for each core.
        output: The bag to write, or a folder; None means beside each bag.
        overwrite: Whether to replace existing bags.
        quiet: Whether to print results and errors only.
    """

    every: int
    max_fps: float | None
    topic: str | None
    camera: CameraOptions
    content: GroundOutput
    bev: bool
    smooth: bool
    threads: int | None
    output: Path | None
    overwrite: bool
    quiet: bool


def infer_bags(
    named: Sequence[str],
    options: BagOptions,
    loading: "tuple[str | None, Sequence[str] | None, str]",
    how: dict[str, Any],
    batch: Batch,
) -> None:
    """Processes the bags in order and prints those written; failures are added to `batch`.

    Args:
        named: The bags.
        options: The options.
        loading: The model, its providers and its engine.
        how: Arguments of `Model.predict`.
        batch: The run.
    """
    model, providers, engine = loading
    predict = partial(load(model, threads=1, providers=providers, engine=engine).predict, **how)
    targets: dict[Path, str] = {}
    for name in named:
        batch.total += 1
        try:
            if is_address(name):
                raise BagError("this is an address; download the bag first")
            target = written_bag(Path(name), options.output)
            if (other := targets.setdefault(real_path(target), name)) != name:
                raise BagError(f"{name} would be written to {target}, as {other}; use another -o")
            interrupted = _infer_bag(Path(name), target, options, predict, batch)
        except Exception as error:  # no error may stop the other bags
            batch.failed(without_password(name), error)
            continue
        if interrupted:
            raise SystemExit(INTERRUPTED)


def _infer_bag(
    path: Path,
    target: Path,
    options: BagOptions,
    predict: "Callable[..., Prediction]",
    batch: Batch,
) -> bool:
    """Processes one bag; returns whether Ctrl-C ended it."""
    if not path.exists():
        raise BagError(f"{path}: no such file")
    refuse_overwriting([target, partial_bag(target)], {real_path(path)})
    if target.exists() and not options.overwrite:
        batch.kept.append(target)
        return False
    bad: list[str] = []
    video, topics = open_bag(
        path,
        Pace(options.every, options.max_fps),
        topic=options.topic,
        with_camera=options.camera.intrinsics is None,
        on_bad=bad.append,
    )
    try:
        sink = BagSink(target, options.content, bev=options.bev)
        then = smoother() if options.smooth else None
    except BaseException:
        video.frames.close()  # type: ignore[attr-defined]
        raise
    progress = ProgressLine(shown=not options.quiet, every_s=REDRAW_S)
    predictor = _Predictor(predict, options.camera.intrinsics, topics, bad)
    try:
        stats = run_pipeline(
            video,
            predictor.predict,
            [sink],
            lambda stats: progress.show(progress_text(video, stats)),
            at_once=options.threads or usable_cores(),
            then=then,
        )
    finally:
        progress.clear()
        if sink.written is not None:
            name_file(sink.written)
        for note in bad[:_MOST_NAMED]:
            complain(f"{path}: {note}")
        if len(bad) > _MOST_NAMED:
            complain(f"{path}: {len(bad) - _MOST_NAMED} more messages could not be used")
    if not options.quiet:
        _report(video, topics, options, predictor, summary_line(video, stats), sink)
    if not stats.frames and not stats.interrupted:
        raise OutputError(f"{video.name} has no usable picture; {stats.reason or 'it is empty'}")
    return stats.interrupted


def _report(
    video: Video,
    topics: Topics,
    options: BagOptions,
    predictor: "_Predictor",
    summary: str,
    sink: BagSink,
) -> None:
    if sink.without_ground:
        summary += f", {sink.without_ground} without a ground plane, and so without a grid"
    complain(summary)
    if not predictor.lens_assumed:
        return
    if options.camera.intrinsics is None and topics.camera is None:
        complain(f"{video.name} has no camera_info beside {topics.images}.")
    complain(lens_warning("assumed"))


class _Predictor:
    """Predicts pictures with their own cameras, and names those that fail."""

    def __init__(
        self,
        predict: "Callable[..., Prediction]",
        given_camera: "Camera | None",
        topics: Topics,
        bad: list[str],
    ) -> None:
        self._predict, self._given, self._topics, self._bad = predict, given_camera, topics, bad
        self.lens_assumed = False

    def predict(self, frame: VideoFrame) -> "Prediction":
        """Predicts a frame; called from several threads."""
        assert isinstance(frame, BagFrame)
        camera = frame.camera if self._given is None else self._given
        try:
            prediction = self._predict(frame.image, intrinsics=camera)
        except FootprintsError as error:
            name = message_name(self._topics.images, frame.index, frame.header)
            self._bad.append(f"{name}: {error}")
            raise
        self.lens_assumed |= prediction.intrinsics.source == "assumed"
        return prediction
