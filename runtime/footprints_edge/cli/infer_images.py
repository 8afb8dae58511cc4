"""The part of `fp-infer` for pictures."""

import sys
from typing import TYPE_CHECKING

import typer

from footprints_edge.cli.batch import Batch, Task
from footprints_edge.cli.camera_options import CameraOptions, lens_warning
from footprints_edge.cli.exit_codes import complain
from footprints_edge.cli.progress import ProgressLine, bar
from footprints_edge.errors import FootprintsError, ImageError

if TYPE_CHECKING:
    from footprints_edge.model import Model
    from footprints_edge.prediction import Prediction


def infer_images(
    batch: Batch,
    model: "Model",
    camera: CameraOptions,
    threshold: float,
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
        try:
            prediction = _predict_and_write(task, model, camera, threshold)
        except FootprintsError as error:
            batch.failures.append(str(error))
            continue
        except Exception as error:  # no error may stop the other pictures
            reason = f"{type(error).__name__}: {error}"
            batch.failures.append(f"{task.source.label} cannot be processed: {reason}")
            continue
        progress.clear()
        if not warning and not quiet:
            warning = lens_warning(prediction.intrinsics.source)
            if warning:
                complain(warning)
        if verbose:
            complain(_summary_line(task, prediction))
        for path in task.targets:
            typer.echo(path)
    progress.clear()


def _predict_and_write(
    task: Task, model: "Model", camera: CameraOptions, threshold: float
) -> "Prediction":
    from footprints_edge.outputs.writers import write

    image = task.source.path or _standard_input()
    prediction = model.predict(image, threshold=threshold, **camera.of_predict())
    write(prediction, task.targets)
    return prediction


def _standard_input() -> bytes:
    data = sys.stdin.buffer.read() if sys.stdin else b""
    if not data:
        raise ImageError("standard input is empty; pipe a picture into it")
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
