"""The part of `fp-infer` for pictures."""

import sys
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from footprints_edge.cli.batch import Batch, Task
from footprints_edge.cli.camera_options import lens_warning
from footprints_edge.cli.exit_codes import complain, name_file
from footprints_edge.cli.progress import ProgressLine, bar
from footprints_edge.errors import FootprintsError, ImageError, ModelError
from footprints_edge.inputs.images import MAX_BYTES
from footprints_edge.outputs.writers import write
from footprints_edge.parallel.in_order import PredictionIterator

if TYPE_CHECKING:
    from collections.abc import Callable

    from footprints_edge.inputs.images import ImageSource
    from footprints_edge.prediction import Prediction

_FINISHING_S = 5.0
"""How long pictures that are being worked on may still take after Ctrl-C."""


@dataclass
class Outcome:
    """What became of one picture.

    Attributes:
        written: The files written.
        notes: What is wrong with the picture, though it could be read.
        lens: Source of the camera; empty if there is no prediction.
        line: Summary for the user, if wanted.
        failure: Why it failed; empty if it did not.
        model_failed: Whether that is because of the model.
    """

    written: list[Path] = field(default_factory=list)
    notes: tuple[str, ...] = ()
    lens: str = ""
    line: str = ""
    failure: str = ""
    model_failed: bool = False


def infer_images(
    batch: Batch,
    predict: "Callable[[ImageSource], Prediction]",
    *,
    at_once: int,
    quiet: bool,
    verbose: bool,
) -> None:
    """Runs the tasks of a batch and prints the files written, in the order of the pictures.

    A picture that fails is added to the batch's failures and does not stop the others. After
    Ctrl-C, those that are being worked on may still be finished.

    Args:
        batch: The tasks.
        predict: Finds the ground in a picture; called from `at_once` threads.
        at_once: Pictures to read, predict and write at a time. If it is more than 1, the model is
            best loaded with one thread.
        quiet: Whether to print results and errors only.
        verbose: Whether to print a line for each picture.
    """
    report = Reporter(batch, quiet=quiet)
    outcomes = PredictionIterator(partial(work, predict, verbose=verbose), batch.tasks, at_once)
    try:
        for done, task in enumerate(batch.tasks):
            report.show(done, task)
            report(next(outcomes))
    except BaseException as ended:
        finished = outcomes.stop(_FINISHING_S)
        if isinstance(ended, KeyboardInterrupt):  # else nobody reads what is reported
            for outcome in finished:
                report(outcome)
        raise
    finally:
        report.clear()


class Reporter:
    """Tells the user and the batch what became of pictures, in the order in which it is called."""

    def __init__(self, batch: Batch, *, quiet: bool) -> None:
        """Nothing is told yet.

        Args:
            batch: Takes failures and notes.
            quiet: Whether to print results and errors only.
        """
        self._batch, self._quiet = batch, quiet
        self._progress = ProgressLine(shown=len(batch.tasks) > 1 and not quiet)
        self._warning = ""

    def show(self, done: int, task: Task) -> None:
        """Shows how far the batch is."""
        self._progress.show(bar(done, len(self._batch.tasks), task.source.label))

    def __call__(self, outcome: Outcome) -> None:
        """Reports a picture."""
        self._progress.clear()
        if outcome.failure:
            self._batch.failures.append(outcome.failure)
            self._batch.model_failures += outcome.model_failed
        self._batch.notes += outcome.notes
        if not (self._warning or self._quiet) and (warning := lens_warning(outcome.lens)):
            complain(warning)
            self._warning = warning
        if outcome.line:
            complain(outcome.line)
        for path in outcome.written:
            name_file(path)

    def clear(self) -> None:
        """Removes the progress."""
        self._progress.clear()


def work(predict: "Callable[[ImageSource], Prediction]", task: Task, *, verbose: bool) -> Outcome:
    """Predicts one picture and writes its files; raises nothing but Ctrl-C."""
    outcome = Outcome()
    try:
        prediction = predict(task.source.path or _standard_input())
        outcome.lens = prediction.intrinsics.source
        line = _summary_line(task, prediction) if verbose else ""
        write(prediction, task.targets, outcome.written.append)
    except FootprintsError as error:
        outcome.failure = _named(error, task)
        outcome.model_failed = isinstance(error, ModelError)
    except Exception as error:  # no error may stop the other pictures
        reason = f"{type(error).__name__}: {error}"
        outcome.failure = f"{task.source.label} cannot be processed: {reason}"
    else:
        outcome.line, outcome.notes = line, prediction.notes
    return outcome


def _named(error: FootprintsError, task: Task) -> str:
    """The message, which names the picture."""
    said = str(error)
    return said if task.source.label in said else f"{task.source.label}: {said}"


def _standard_input() -> bytes:
    data = sys.stdin.buffer.read(MAX_BYTES + 1) if sys.stdin else b""
    if not data:
        raise ImageError("standard input is empty; pipe a picture into it")
    if len(data) > MAX_BYTES:
        raise ImageError(f"standard input: longer than {MAX_BYTES} bytes; is it a picture?")
    return data


def _summary_line(task: Task, prediction: "Prediction") -> str:
    height, width = prediction.image_size
    camera = prediction.intrinsics
    ground = ""
    if prediction.has("ground_probability"):
        visible, hidden = prediction.visible_ground.mean(), prediction.hidden_ground.mean()
        ground = f"visible ground {visible:.0%}, hidden {hidden:.0%}, "
    timings = ", ".join(f"{stage} {ms:.1f}" for stage, ms in prediction.timings_ms.items())
    return (
        f"{task.source.label}: {width} x {height} px, "
        f"{ground}"
        f"field of view {camera.hfov_deg(prediction.map_size):.0f} degrees ({camera.source}), "
        f"ms: {timings}"
    )
