"""The part of `fp-infer` for pictures."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from footprints_edge.cli.batch import Batch, Task
from footprints_edge.cli.camera_options import lens_warning
from footprints_edge.cli.exit_codes import complain, name_file
from footprints_edge.cli.progress import ProgressLine, bar
from footprints_edge.errors import FootprintsError, ImageError, ModelError
from footprints_edge.inputs.images import MAX_BYTES
from footprints_edge.outputs.writers import write

if TYPE_CHECKING:
    from collections.abc import Callable

    from footprints_edge.inputs.images import ImageSource
    from footprints_edge.prediction import Prediction


def infer_images(
    batch: Batch,
    predict: "Callable[[ImageSource], Prediction]",
    *,
    quiet: bool,
    verbose: bool,
) -> None:
    """Runs the tasks of a batch and prints the files written.

    A picture that fails is added to the batch's failures and does not stop the others.
    """
    progress = ProgressLine(shown=len(batch.tasks) > 1 and not quiet)
    warning = ""
    for done, task in enumerate(batch.tasks):
        progress.show(bar(done, len(batch.tasks), task.source.label))
        written: list[Path] = []
        lens = ""
        try:
            prediction = predict(task.source.path or _standard_input())
            lens = prediction.intrinsics.source
            line = _summary_line(task, prediction) if verbose else ""
            write(prediction, task.targets, written.append)
        except FootprintsError as error:
            line = ""
            batch.failures.append(_named(error, task))
            batch.model_failures += isinstance(error, ModelError)
        except Exception as error:  # no error may stop the other pictures
            line = ""
            reason = f"{type(error).__name__}: {error}"
            batch.failures.append(f"{task.source.label} cannot be processed: {reason}")
        else:
            batch.notes += prediction.notes
        progress.clear()
        if not (warning or quiet) and (warning := lens_warning(lens)):
            complain(warning)
        if line:
            complain(line)
        for path in written:
            name_file(path)
    progress.clear()


def _named(error: FootprintsError, task: Task) -> str:
    """The message, which names the picture."""
    said = str(error)
    return said if task.source.label in said else f"{task.source.label}: {said}"


def _standard_input() -> bytes:
    data = sys.stdin.buffer.read(MAX_BYTES + 1) if sys.stdin else b""
    if not data:
        raise ImageError("standard input is empty; pipe a picture into it")
    if len(data) > MAX_BYTES:
        raise ImageError(f"standard input: larger than {MAX_BYTES} bytes; is it a picture?")
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
