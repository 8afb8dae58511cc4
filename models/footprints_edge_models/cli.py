"""``fp-train``: training data and training."""

import json
import logging
import re
import sys
import time
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from footprints_edge.cli.exit_codes import SOME_FAILED, complain, explained

if TYPE_CHECKING:
    from collections.abc import Callable

    import torch

    from footprints_edge_models.sequences.sequence import Sequence
    from footprints_edge_models.training.trainer import Recipe
    from footprints_edge_models.video_labels.job import FrameOutcome, LabelJob, Report

app = typer.Typer(
    name="fp-train",
    help="Train the networks of footprints-edge.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=False,
)

DEFAULT_STAGES = ("128x224:2400", "192x320:1600", "256x448:700")

Data = Annotated[Path, typer.Argument(help="Folder of the datasets (see CONTRIBUTING.md).")]
Stages = Annotated[
    list[str],
    typer.Option(metavar="HxW:STEPS", help="A size and how long; repeat for more stages."),
]
Batch = Annotated[int, typer.Option(min=1, help="Pictures a step.")]
Seed = Annotated[int, typer.Option(help="Seed of weights and data.")]
Start = Annotated[
    Path | None, typer.Option(help="Weights to begin with; else an ImageNet encoder.")
]
Device = Annotated[str, typer.Option(help="cpu or cuda; cuda where there is one.")]


class Ground(StrEnum):
    """Where the labels' visible ground comes from."""

    GIVEN = "given"
    DEPTH = "depth"
    TEACHER = "teacher"
    MODEL = "model"


class Engine(StrEnum):
    """Where a job runs."""

    LOCAL = "local"
    RAY = "ray"


class Split(StrEnum):
    """What made scenes are for."""

    TRAIN = "train"
    TEST = "test"


@app.callback()
def _root() -> None:
    """Train the networks of footprints-edge."""


@app.command()
def edge(
    data: Data,
    run: Annotated[Path, typer.Option(help="Folder of the run; an unfinished run goes on.")],
    stage: Stages = list(DEFAULT_STAGES),  # noqa: B006  (typer copies it)
    batch: Batch = 12,
    seed: Seed = 0,
    start: Start = None,
    peak: Annotated[
        float,
        typer.Option(help="Of the learning rates, as a share; less to go on from trained weights."),
    ] = 1.0,
    prior: Annotated[
        float, typer.Option(help="The paper's lambda: how much unknown pixels count (eq. 3c).")
    ] = 0.25,
    untraversable: Annotated[
        bool, typer.Option(help="Learn from untraversable pixels (eq. 3b), or as from unknown.")
    ] = True,
    moving: Annotated[
        bool, typer.Option(help="Leave the ground behind moving objects out, or not.")
    ] = True,
    device: Device = "auto",
) -> None:
    """Train the edge network on every dataset found below DATA; prints the path of its weights."""
    with explained("train"):
        ablated = {"prior": prior, "untraversable": untraversable, "moving": moving}
        recipe = _recipe(stage, batch, seed, start, peak=peak, **ablated)
        typer.echo(_train(data, recipe, run, device))


@app.command()
def reference(
    data: Data,
    run: Annotated[Path, typer.Option(help="Folder of the run; an unfinished run goes on.")],
    stage: Stages = ["128x224:2400"],  # noqa: B006  (typer copies it)
    batch: Batch = 12,
    seed: Seed = 0,
    start: Annotated[
        Path | None, typer.Option(help="Weights to begin with; else random ones.")
    ] = None,
    device: Device = "auto",
) -> None:
    """Train the paper's own network likewise; prints the path of its weights.

    Its depths are for a canonical camera, whose focal length it says when it is done.
    """
    with explained("train"):
        from footprints_edge_models.networks.edge import focal_px_at

        recipe = _recipe(stage, batch, seed, start, network="reference")
        weights = _train(data, recipe, run, device)
        focal_px = focal_px_at(recipe.stages[-1].size)
        complain(f"Convert them with --arch reference --focal-px {focal_px:g}")
        typer.echo(weights)


def _recipe(
    stage: list[str],
    batch: int,
    seed: int,
    start: Path | None,
    **more: Any,  # noqa: ANN401  (fields of Recipe)
) -> "Recipe":
    from footprints_edge_models.training.trainer import Recipe, Stage

    stages = tuple(Stage.parse(text) for text in stage)
    weights = None if start is None else str(start)
    return Recipe(stages, batch=batch, seed=seed, start=weights, **more)


def _train(data: Path, recipe: "Recipe", run: Path, device: str) -> Path:
    """Trains behind a progress bar; the path of the weights."""
    from tqdm import tqdm

    from footprints_edge_models.data.datasets import load_datasets
    from footprints_edge_models.training.trainer import train

    where = _device(device)
    datasets = load_datasets(data)
    with tqdm(unit="step", disable=None) as bar:

        def progress(step: int, steps: int, loss: float) -> None:
            bar.total = steps
            bar.set_postfix(loss=f"{loss:.3f}", refresh=False)
            bar.update(step - bar.n)

        return train(datasets, recipe, run, device=where, progress=progress)


@app.command()
def ablations(
    data: Data,
    run: Annotated[Path, typer.Option(help="Folder of the runs; unfinished ones go on.")],
    stage: Stages = ["128x224:600"],  # noqa: B006  (typer copies it)
    batch: Batch = 12,
    seed: Seed = 0,
    start: Start = None,
    device: Device = "auto",
) -> None:
    """Train the paper's ablations of the loss alike; prints tables of their held-out scores."""
    with explained("train"):
        from tqdm import tqdm

        from footprints_edge_models.data.datasets import load_datasets
        from footprints_edge_models.training.ablations import ABLATIONS, train_ablations

        where = _device(device)
        recipe = _recipe(stage, batch, seed, start)
        steps = len(recipe.sizes())
        datasets = load_datasets(data)
        with tqdm(total=len(ABLATIONS) * steps, unit="step", disable=None) as bar:

            def progress(name: str, step: int, steps: int, loss: float) -> None:
                bar.set_postfix_str(f"{name}, loss {loss:.3f}", refresh=False)
                bar.update(list(ABLATIONS).index(name) * steps + step - bar.n)

            tables = train_ablations(datasets, recipe, run, device=where, progress=progress)
        typer.echo(tables)


def _device(name: str) -> "torch.device":
    import torch

    from footprints_edge_models.training.trainer import TrainingError

    if name == "auto":
        name = "cuda" if torch.cuda.is_available() else "cpu"
    if name != "cpu" and not (name.startswith("cuda") and torch.cuda.is_available()):
        raise TrainingError(f"device {name!r}: here only cpu and, where there is one, cuda")
    return torch.device(name)


@app.command()
def labels(
    sequence: Annotated[
        Path,
        typer.Argument(
            help="Folder with sequence.json or image_l/, drive of KITTI raw, or Matterport3D scan."
        ),
    ],
    output: Annotated[
        Path,
        typer.Option("-o", "--output", help="Folder of the labels; an unfinished one goes on."),
    ],
    ground: Annotated[
        Ground,
        typer.Option(
            help="Where visible ground comes from: label files, the floor in the depth, "
            "a segmenter, or our own model."
        ),
    ] = Ground.GIVEN,
    source: Annotated[
        str | None,
        typer.Option(help="The teacher's .tflite file; the model's file or name."),
    ] = None,
    published: Annotated[
        Path | None,
        typer.Option(
            help="Training data published with the paper, folder or zip (KITTI, Matterport)."
        ),
    ] = None,
    size: Annotated[
        str | None,
        typer.Option(metavar="HxW", help="Of the labels; else the picture's, at most 512 px long."),
    ] = None,
    before: Annotated[
        int | None, typer.Option(min=0, help="How many frames back neighbours reach (25).")
    ] = None,
    after: Annotated[
        int | None, typer.Option(min=0, help="How many frames ahead they reach (50).")
    ] = None,
    step: Annotated[int | None, typer.Option(min=1, help="Every which of them counts (2).")] = None,
    jobs: Annotated[
        int | None, typer.Option("-j", "--jobs", min=1, help="Processes; else one a core.")
    ] = None,
    engine: Annotated[
        Engine, typer.Option(help="This machine's cores, or Ray (cluster of RAY_ADDRESS).")
    ] = Engine.LOCAL,
) -> None:
    """Make training labels of a moving camera's frames; prints a line of JSON about them.

    A folder begun before is gone on with. Exit codes: 0 all done, 1 some frames failed, 2 usage.
    """
    with explained("train"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge_models.sequences.layouts import read_sequence
        from footprints_edge_models.video_labels.job import LabelJob
        from footprints_edge_models.video_labels.labeller import LabelSettings

        frames = _with_neighbours(read_sequence(sequence, published), before, after, step)
        settings = LabelSettings(_size(size), ground.value, source)
        job = LabelJob(frames, settings, output.absolute())
        outcomes, seconds = _run(job, engine, jobs or usable_cores())
        _close(job, outcomes, seconds)


def _size(text: str | None) -> tuple[int, int] | None:
    match = re.fullmatch(r"([1-9]\d*)x([1-9]\d*)", text or "")
    if text is not None and match is None:
        raise typer.BadParameter(f"--size {text}: give height x width, such as 256x448")
    return (int(match[1]), int(match[2])) if match else None


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


def _run(job: "LabelJob", engine: Engine, processes: int) -> tuple[list["FrameOutcome"], float]:
    """Labels the frames behind a progress bar; every frame's outcome, and how long it took."""
    from tqdm import tqdm

    outcomes: list[FrameOutcome] = []
    with tqdm(total=len(job.sequence.frames), unit="frame", disable=None) as bar:

        def report(outcome: "FrameOutcome") -> None:
            outcomes.append(outcome)
            if outcome.state == "failed":
                bar.clear()
                complain(f"{outcome.name} failed: {outcome.reason}")
            bar.update()

        start = time.perf_counter()
        _engine(engine)(job, processes, report)
        return outcomes, time.perf_counter() - start


def _engine(engine: Engine) -> "Callable[[LabelJob, int, Report], None]":
    if engine is Engine.RAY:
        with explained("ray"):
            from footprints_edge_models.video_labels.on_ray import run_on_ray

            return run_on_ray
    from footprints_edge_models.video_labels.processes import run_in_processes

    return run_in_processes


def _close(job: "LabelJob", outcomes: list["FrameOutcome"], seconds: float) -> None:
    """Draws the contact sheet, says how it went, and sets the exit code."""
    from footprints_edge_models.video_labels.contact_sheet import write_contact_sheet
    from footprints_edge_models.video_labels.job import hidden_share

    count = {state: sum(o.state == state for o in outcomes) for state in ("done", "kept", "failed")}
    share = hidden_share(outcomes)
    sheet = write_contact_sheet(job.folder) if count["done"] or count["kept"] else None
    summary = {
        "labels": str(job.folder),
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


@app.command()
def scenes(
    output: Annotated[Path, typer.Argument(help="Folder; one begun before is gone on with.")],
    count: Annotated[int, typer.Option(min=0, help="How many scenes the folder shall hold.")],
    seed: Annotated[int, typer.Option(min=0, help="Of the set; a split has seeds of its own.")] = 0,
    size: Annotated[
        str, typer.Option(metavar="HxW", help="Of landscape pictures; one in three is not.")
    ] = "256x448",
    split: Annotated[
        Split, typer.Option(help="test adds boxes and voxels, and shares no texture with train.")
    ] = Split.TRAIN,
    textures: Annotated[
        list[Path] | None,
        typer.Option(
            exists=True, file_okay=False, help="Folder of photos for textures; repeat for more."
        ),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option("-j", "--jobs", min=1, help="Processes; else one a core.")
    ] = None,
    preview: Annotated[
        Path | None, typer.Option(help="Write a contact sheet of the folder, a PNG.")
    ] = None,
) -> None:
    """Make rooms and streets whose visible and hidden ground is known exactly; prints JSON."""
    with explained("train"):
        from tqdm import tqdm

        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge_models.scenes.make import make_scenes
        from footprints_edge_models.scenes.storage.files import SceneSettings
        from footprints_edge_models.scenes.storage.preview import write_preview

        settings = SceneSettings(split.value, seed, _size(size) or (256, 448))
        processes = jobs or usable_cores()
        written: list[int] = []
        start = time.perf_counter()
        with tqdm(total=count, unit="scene", disable=None) as bar:

            def report(size_bytes: int) -> None:
                if size_bytes:
                    written.append(size_bytes)
                bar.update()

            make_scenes(output, settings, textures or [], count, processes, report)
        seconds = time.perf_counter() - start
        if preview is not None:
            write_preview(output, preview)
        summary = {
            "scenes": str(output),
            "split": split.value,
            "made": len(written),
            "kept": count - len(written),
            "processes": processes,
            "scenes_per_second_and_process": round(len(written) / seconds / processes, 2),
            "bytes_per_scene": round(sum(written) / len(written)) if written else None,
        }
        typer.echo(json.dumps(summary))


def main() -> None:
    """Entry point of ``fp-train``."""
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
    app()


if __name__ == "__main__":
    main()
