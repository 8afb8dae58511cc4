"""``fp-train labels``: training labels of a moving camera's frames."""

import json
import time
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from footprints_edge.cli.exit_codes import SOME_FAILED, complain, explained
from footprints_edge_models.cli.options import Engine, JobEngine, Jobs, size_of

if TYPE_CHECKING:
    from footprints_edge_models.sequences.sequence import Sequence
    from footprints_edge_models.video_labels.job import FrameOutcome, LabelJob, LabelRunner


class GroundOrigin(StrEnum):
    """Where the labels' visible ground comes from."""

    GIVEN = "given"
    DEPTH = "depth"
    TEACHER = "teacher"
    MODEL = "model"


def labels(
    sequence: Annotated[
        Path,
        typer.Argument(
            help="Folder with sequence.json or image_l/, TUM RGB-D clip, ScanNet scan, recording "
            "of Stray Scanner, COLMAP reconstruction, drive of KITTI raw, or Matterport3D scan."
        ),
    ],
    output: Annotated[
        Path,
        typer.Option(
            "-o", "--output", help="Folder of the labels; an unfinished folder is resumed."
        ),
    ],
    ground: Annotated[
        GroundOrigin | None,
        typer.Option(
            help="Source of visible ground: label files, the floor in the depth, a segmenter, "
            "or a model of this package. Default: the first that the sequence has of label files, "
            "measured depth, and a model."
        ),
    ] = None,
    source: Annotated[
        str | None,
        typer.Option(help="The teacher's .tflite file, or the model's file or name."),
    ] = None,
    published: Annotated[
        Path | None,
        typer.Option(
            help="Training data published with the paper, folder or zip (KITTI, Matterport)."
        ),
    ] = None,
    size: Annotated[
        str | None,
        typer.Option(metavar="HxW", help="Size of the labels; default: at most 512 px long."),
    ] = None,
    before: Annotated[
        int | None, typer.Option(min=0, help="Frames before this one to take ground from (25).")
    ] = None,
    after: Annotated[
        int | None, typer.Option(min=0, help="Frames after this one to take ground from (50).")
    ] = None,
    step: Annotated[
        int | None, typer.Option(min=1, help="Use every Nth neighbouring frame (2).")
    ] = None,
    jobs: Jobs = None,
    engine: Engine = JobEngine.LOCAL,
) -> None:
    """Make training labels of a moving camera's frames; print a summary as JSON.

    An unfinished folder is resumed. Exit codes: 0 all done, 1 some frames failed, 2 usage, 3
    problem with the model or the teacher.
    """
    with explained("train"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge_models.sequences.layouts import read_sequence
        from footprints_edge_models.video_labels.job import LabelJob
        from footprints_edge_models.video_labels.labeller import LabelSettings
        from footprints_edge_models.video_labels.visible_ground import best_ground

        frames = _with_neighbours(read_sequence(sequence, published), before, after, step)
        origin = best_ground(frames) if ground is None else ground.value
        settings = LabelSettings(size_of(size) if size else None, origin, source)
        job = LabelJob(frames, settings, output.absolute())
        outcomes, seconds = _run(job, _runner(engine, jobs or usable_cores()))
        _summarise(job, outcomes, seconds)


def _with_neighbours(
    sequence: "Sequence", before: int | None, after: int | None, step: int | None
) -> "Sequence":
    """The sequence with the reach of its neighbours in time changed as the options say."""
    from dataclasses import replace

    from footprints_edge_models.sequences.sequence import InTime

    given = {"before": before, "after": after, "step": step}
    changes = {name: value for name, value in given.items() if value is not None}
    if not changes:
        return sequence
    if not isinstance(sequence.neighbours, InTime):
        raise typer.BadParameter(
            f"--{next(iter(changes))}: frames of {sequence.name} are neighbours in space, not time"
        )
    return replace(sequence, neighbours=replace(sequence.neighbours, **changes))


def _runner(engine: JobEngine, processes: int) -> "LabelRunner":
    from functools import partial

    if engine is JobEngine.RAY:
        with explained("ray"):
            import ray  # noqa: F401  (says now what is missing)

        from footprints_edge.parallel.on_ray import run_on_ray
        from footprints_edge_models.video_labels.job import FRAMES_PER_TASK

        return partial(run_on_ray, workers=processes, run_length=FRAMES_PER_TASK)
    from footprints_edge.parallel.processes import run_in_processes

    return partial(run_in_processes, processes=processes)


def _run(job: "LabelJob", runner: "LabelRunner") -> tuple[list["FrameOutcome"], float]:
    """Labels the frames behind a progress bar; every frame's outcome, and the seconds it took."""
    from tqdm import tqdm

    from footprints_edge_models.video_labels.job import make_labels

    outcomes: list[FrameOutcome] = []
    with tqdm(total=len(job.sequence.frames), unit="frame", disable=None) as bar:

        def report(outcome: "FrameOutcome") -> None:
            outcomes.append(outcome)
            if outcome.state == "failed":
                bar.clear()
                complain(f"{outcome.name} failed: {outcome.reason}")
            bar.update()

        start = time.perf_counter()
        make_labels(job, runner, report)
        return outcomes, time.perf_counter() - start


def _summarise(job: "LabelJob", outcomes: list["FrameOutcome"], seconds: float) -> None:
    """Draws the contact sheet, prints the summary, and sets the exit code."""
    from footprints_edge_models.video_labels.contact_sheet import write_contact_sheet
    from footprints_edge_models.video_labels.job import hidden_share

    count = {state: sum(o.state == state for o in outcomes) for state in ("done", "kept", "failed")}
    share = hidden_share(outcomes)
    sheet = write_contact_sheet(job.folder) if count["done"] or count["kept"] else None
    summary = {
        "labels": str(job.folder),
        "ground": job.settings.ground,
        "frames": len(outcomes),
        **count,
        "hidden_ground_share": None if share is None else round(share, 4),
        "frames_per_second": round(count["done"] / seconds, 3) if count["done"] else None,
        "contact_sheet": None if sheet is None else str(sheet),
    }
    typer.echo(json.dumps(summary))
    if count["failed"]:
        complain(f"{count['failed']} of {len(outcomes)} frames failed; run it again to retry them")
        raise typer.Exit(SOME_FAILED)
