"""``fp-bench``: how accurate the models are, and how fast."""

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import SOME_FAILED, complain, explained

app = typer.Typer(
    name="fp-bench",
    help="Measure the models of footprints-edge.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=False,
)


Frames = Annotated[
    str, typer.Option(metavar="A:B", help="Part of each dataset; 0.8:1 is the last fifth.")
]
Every = Annotated[int, typer.Option(min=1, help="Take every so manieth image only.")]
HeldOut = Annotated[
    bool,
    typer.Option(
        "--held-out", help="Only what fp-train edge holds out of datasets it knows by name."
    ),
]
Threads = Annotated[
    int | None,
    typer.Option(min=1, max=256, help="Threads of one frame.  [default: the usable cores]"),
]


@app.callback()
def _root() -> None:
    """Measure the models of footprints-edge."""


@app.command()
def accuracy(
    data: Annotated[
        list[Path],
        typer.Argument(
            help="Folders: RGB-D clips, KITTI or Matterport ground truth, labelled photos; see "
            "docs/accuracy.md."
        ),
    ],
    *,
    output: Annotated[
        Path,
        typer.Option("-o", "--output", help="Folder of the results; an unfinished run goes on."),
    ] = Path("accuracy"),
    model: Annotated[
        list[str] | None,
        typer.Option(help="Model file, or a name that fp-models list shows; repeat for more."),
    ] = None,
    images: Annotated[
        Path | None,
        typer.Option(help="Where KITTI's or Matterport's pictures are: a folder, or KITTI's list."),
    ] = None,
    walkable: Annotated[
        str, typer.Option(metavar="ID,…", help="Class ids of ground in labelled photos.")
    ] = "",
    void: Annotated[str, typer.Option(metavar="ID,…", help="Class ids that are not scored.")] = "",
    frames: Frames = "0:1",
    held_out: HeldOut = False,
    every: Every = 1,
    boxes: Annotated[
        Path | None, typer.Option(help="JSON of oriented boxes, for the box baseline.")
    ] = None,
    voxels: Annotated[
        Path | None, typer.Option(help="Folder of voxel grids, for the voxel baselines.")
    ] = None,
    unflattened: Annotated[
        bool,
        typer.Option(
            "--unflattened", help="Also with ground depth as the network says, not laid flat."
        ),
    ] = False,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Throw away the results that are there already.")
    ] = False,
) -> None:
    """Score models and the paper's baselines; prints the tables as Markdown.

    Exit codes: 0 all done, 1 some images failed, 2 wrong usage, 3 problem with the model.
    """
    with explained("bench"):
        from tqdm import tqdm

        from footprints_edge.model import load
        from footprints_edge_bench.accuracy.benchmark import (
            BaselineInputs,
            Benchmark,
            evaluate,
            name_models,
            write_reports,
        )
        from footprints_edge_bench.accuracy.results import Results
        from footprints_edge_bench.geometry.boxes import read_boxes
        from footprints_edge_bench.ground_truth.datasets import (
            ReadingOptions,
            Subset,
            open_datasets,
        )

        reading = ReadingOptions(images, _ids(walkable, "--walkable"), _ids(void, "--void"))
        if voxels is not None and not voxels.is_dir():
            raise typer.BadParameter(f"--voxels {voxels} is no folder")
        benchmark = Benchmark(
            open_datasets(data, reading, Subset.parse(frames, every, held_out=held_out)),
            name_models([load(name) for name in model] if model else [load()]),
            BaselineInputs({} if boxes is None else read_boxes(boxes), boxes, voxels),
            {
                "frames": frames,
                "every": every,
                "held_out": held_out,
                "walkable": list(reading.walkable),
                "void": list(reading.void),
            },
            unflattened,
        )
        results = Results(output / "results.jsonl", benchmark.settings(), fresh=fresh)
        with tqdm(total=len(benchmark.items()), unit="image", disable=None) as bar:

            def progress(name: str) -> None:
                bar.set_postfix_str(name, refresh=False)
                bar.update()

            failures = evaluate(benchmark, results, progress)
        typer.echo(write_reports(benchmark, results, failures, output), nl=False)
        for name, reason in failures.items():
            complain(f"Skipped {name}: {reason}")
        if failures:
            complain(f"{len(failures)} of {len(benchmark.items())} images failed.")
            raise typer.Exit(SOME_FAILED)


@app.command()
def planning(
    data: Annotated[
        list[Path],
        typer.Argument(help="Folders with ground truth of hidden ground: clips, synthetic scenes."),
    ],
    *,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder of planning.md and planning.csv.")
    ] = Path("planning"),
    model: Annotated[
        list[str] | None, typer.Option(help="Model file, or a registered name; repeat for more.")
    ] = None,
    paths: Annotated[int, typer.Option(min=1, help="Paths on each image; the paper: 1.")] = 5,
    seed: Annotated[int, typer.Option(min=0, help="Of the ends of the paths.")] = 0,
    frames: Frames = "0:1",
    held_out: HeldOut = False,
    every: Every = 1,
) -> None:
    """Plan paths to hidden ground over each method's ground; prints the paper's table.

    Exit codes: 0 all done, 1 some images failed, 2 wrong usage, 3 problem with the model.
    """
    with explained("bench"):
        from tqdm import tqdm

        from footprints_edge.model import load
        from footprints_edge.navigation.path_planning import require_graph_search
        from footprints_edge_bench.accuracy.benchmark import BaselineInputs, Benchmark, name_models
        from footprints_edge_bench.ground_truth.datasets import (
            ReadingOptions,
            Subset,
            open_datasets,
        )
        from footprints_edge_bench.navigation.path_planning import (
            as_markdown,
            plan_paths,
            write_paths,
        )

        require_graph_search()
        benchmark = Benchmark(
            open_datasets(data, ReadingOptions(), Subset.parse(frames, every, held_out=held_out)),
            name_models([load(name) for name in model] if model else [load()]),
            BaselineInputs({}),
            {},
        )
        with tqdm(total=len(benchmark.items()), unit="image", disable=None) as bar:
            scores, failures = plan_paths(benchmark, paths, seed, lambda _: bar.update())
        markdown = as_markdown(benchmark, scores, failures, paths)
        output.mkdir(parents=True, exist_ok=True)
        (output / "planning.md").write_text(markdown, encoding="utf-8")
        write_paths(scores, output / "planning.csv")
        typer.echo(markdown, nl=False)
        if failures:
            raise typer.Exit(SOME_FAILED)


@app.command("from-above")
def from_above(
    data: Annotated[
        list[Path],
        typer.Argument(help="Folders with ground truth of all four maps: synthetic scenes, clips."),
    ],
    *,
    model: Annotated[
        list[str] | None, typer.Option(help="Model file, or a registered name; repeat for more.")
    ] = None,
    frames: Frames = "0:1",
    held_out: HeldOut = False,
    every: Every = 1,
) -> None:
    """Print how right free space in metres is: top-down grids against those of exact maps.

    Exit codes: 0 done, 2 wrong usage, 3 problem with the model.
    """
    with explained("bench"):
        from tqdm import tqdm

        from footprints_edge.model import load
        from footprints_edge_bench.accuracy.benchmark import BaselineInputs, Benchmark, name_models
        from footprints_edge_bench.ground_truth.datasets import (
            ReadingOptions,
            Subset,
            open_datasets,
        )
        from footprints_edge_bench.navigation.occupancy import as_markdown, score_grids

        benchmark = Benchmark(
            open_datasets(data, ReadingOptions(), Subset.parse(frames, every, held_out=held_out)),
            name_models([load(name) for name in model] if model else [load()]),
            BaselineInputs({}),
            {},
        )
        with tqdm(total=len(benchmark.items()), unit="image", disable=None) as bar:
            scores = score_grids(benchmark, lambda _: bar.update())
        typer.echo(as_markdown(scores), nl=False)


@app.command()
def steadiness(
    clips: Annotated[list[Path], typer.Argument(help="Folders of RGB-D clips with poses.")],
    *,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Also write it as Markdown, here.")
    ] = None,
    model: Annotated[str | None, typer.Option(help="Model file, or a registered name.")] = None,
    frames: Frames = "0:1",
    every: Every = 1,
) -> None:
    """Print how much maps flicker frame by frame and smoothed, and what smoothing costs.

    Exit codes: 0 all done, 2 wrong usage, 3 problem with the model.
    """
    with explained("bench"):
        from footprints_edge.model import load
        from footprints_edge_bench.ground_truth.datasets import Subset
        from footprints_edge_bench.temporal.flicker import SMOOTHINGS, as_markdown, measure

        loaded, part = load(model), Subset.parse(frames, every)
        markdown = as_markdown(
            {clip.resolve().name: measure(clip, part, loaded, SMOOTHINGS) for clip in clips}
        )
        if output is not None:
            output.write_text(markdown, encoding="utf-8")
        typer.echo(markdown, nl=False)


@app.command("video")
def video_command(
    video: Annotated[Path, typer.Argument(help="A video file.")],
    *,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Also write it as JSON, to this file.")
    ] = None,
    model: Annotated[str | None, typer.Option(help="Model file, or a registered name.")] = None,
    threads: Threads = None,
    length: Annotated[
        int, typer.Option(min=400, help="Frames to run; the video is repeated until they are full.")
    ] = 2000,
) -> None:
    """Print how fast a video goes through fp-infer, against inference alone, and its memory.

    Exit codes: 0 all done, 2 wrong usage, 3 problem with the model.
    """
    with explained("bench"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge_bench.temporal.video_throughput import measure_video

        found = measure_video(video, model, threads or usable_cores(), length)
        if output is not None:
            output.write_text(found.as_json(), encoding="utf-8")
        typer.echo(found.as_markdown(), nl=False)


EdgeCheckpoint = Annotated[
    Path, typer.Option(help="Weights of the edge network, for its float rows.")
]
Cache = Annotated[
    Path | None,
    typer.Option(help="Folder that keeps converted networks.  [default: the user's cache]"),
]
Only = Annotated[
    list[str] | None,
    typer.Option(metavar="ROW", help="Rows whose name holds this; repeat for more."),
]
FurtherModels = Annotated[
    list[str] | None, typer.Option(help="A further model file as a row; repeat for more.")
]
ReferenceSizes = Annotated[
    list[str] | None,
    typer.Option(metavar="HxW", help="Of the reference network; repeat.  [default: presets]"),
]
EDGE_CHECKPOINT = Path("models/weights/edge.pt")


class SpinningChoice(StrEnum):
    """What onnxruntime's threads do while they wait."""

    SHIPPED = "shipped"
    ON = "on"
    OFF = "off"


@app.command()
def latency(
    *,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder of latency.md, .json and .png.")
    ] = Path("latency"),
    threads: Threads = None,
    spinning: Annotated[
        SpinningChoice,
        typer.Option(
            help="onnxruntime's threads: spin within a frame only, as the runtime package does; "
            "between frames too; or never."
        ),
    ] = SpinningChoice.SHIPPED,
    trials: Annotated[int, typer.Option(min=2, help="Timed frames of each row.")] = 50,
    only: Only = None,
    model: FurtherModels = None,
    size: ReferenceSizes = None,
    photos: Annotated[
        Path | None, typer.Option(help="Photos to judge accuracy on.  [default: made-up ones]")
    ] = None,
    processes: Annotated[
        int, typer.Option(min=0, help="Fresh processes for the cold start; 0 leaves it out.")
    ] = 7,
    network_only: Annotated[
        bool, typer.Option("--network-only", help="Leave out the whole frame and the cold start.")
    ] = False,
    edge_checkpoint: EdgeCheckpoint = EDGE_CHECKPOINT,
    cache: Cache = None,
) -> None:
    """Time networks in onnxruntime and its peers, one frame at a time, accuracy beside them.

    Exit codes: 0 done, peers that cannot run are named; 1 a row of onnxruntime could not run, or
    none could; 2 wrong usage, 3 problem with a model.
    """
    with explained("bench"):
        from tqdm import tqdm

        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge.model import load
        from footprints_edge_bench.engines.backend import BackendSetting, Spinning
        from footprints_edge_bench.latency.benchmark import photos_by_size, run, select_backends
        from footprints_edge_bench.latency.cold_start import cold_start
        from footprints_edge_bench.latency.end_to_end import EndToEnd, end_to_end
        from footprints_edge_bench.latency.machine import machine
        from footprints_edge_bench.latency.plot import draw
        from footprints_edge_bench.latency.tables import markdown, write
        from footprints_edge_bench.model_files.model_cache import ModelCache, default_folder

        here = machine()
        count = threads or usable_cores()
        rows = select_backends(only or (), model or (), [_size(text) for text in size or ()])
        files = ModelCache(cache or default_folder(), edge_checkpoint)
        setting = BackendSetting(files, count, Spinning(spinning.value))
        images = None if photos is None else photos_by_size(photos, rows)
        output.mkdir(parents=True, exist_ok=True)
        with tqdm(total=trials * len(rows), unit="frame", disable=None) as bar:

            def progress(name: str) -> None:
                bar.set_postfix_str(name, refresh=False)
                bar.update()

            report = run(rows, setting, here, trials, images, progress)
        whole: Sequence[EndToEnd] = ()
        cold = None
        ours = {"edge int8": ""} | {name: name for name in model or ()}
        if not network_only:
            loaded = {row: load(file or None, threads=count) for row, file in ours.items()}
            whole = end_to_end(loaded, trials)
            cold = cold_start(ours, count, processes) if processes else None
        write(report, whole, cold, output)
        draw(report, output / "latency.png")
        typer.echo(markdown(report, whole, cold), nl=False)
        for row in report.rows:
            if row.reason is not None:
                complain(f"Not run: {row.name}: {row.reason}")
        if report.failed():
            raise typer.Exit(SOME_FAILED)


@app.command("table")
def table_command(
    *,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Also write it as JSON, to this file.")
    ] = None,
    preset: Annotated[
        list[str] | None,
        typer.Option(help="kitti, handheld or matterport; repeat for more.  [default: all]"),
    ] = None,
    threads: Threads = None,
    trials: Annotated[int, typer.Option(min=2, help="Timed frames of each row.")] = 30,
    edge_checkpoint: EdgeCheckpoint = EDGE_CHECKPOINT,
    cache: Cache = None,
) -> None:
    """Print the paper's speed table as Markdown: its rows quoted, ours measured here.

    Exit codes: 0 all done, 1 some rows could not run, 2 wrong usage, 3 problem with a model.
    """
    with explained("bench"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge_bench.engines.backend import BackendSetting
        from footprints_edge_bench.latency.benchmark import PRESETS
        from footprints_edge_bench.latency.machine import machine
        from footprints_edge_bench.latency.paper_table import speed_table
        from footprints_edge_bench.model_files.model_cache import ModelCache, default_folder

        for name in preset or ():
            if name not in PRESETS:
                raise typer.BadParameter(f"--preset {name}: choose from {', '.join(PRESETS)}")
        files = ModelCache(cache or default_folder(), edge_checkpoint)
        found = speed_table(
            BackendSetting(files, threads or usable_cores()),
            machine(),
            trials,
            tuple(preset or PRESETS),
        )
        if output is not None:
            output.write_text(found.as_json(), encoding="utf-8")
        typer.echo(found.as_markdown(), nl=False)
        if any(row.reason for row in found.rows):
            raise typer.Exit(SOME_FAILED)


@app.command()
def roofline(
    *,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Also write it as JSON, to this file.")
    ] = None,
    only: Only = None,
    model: FurtherModels = None,
    size: ReferenceSizes = None,
    threads: Threads = None,
    trials: Annotated[int, typer.Option(min=1, help="Timed frames of each row.")] = 10,
    edge_checkpoint: EdgeCheckpoint = EDGE_CHECKPOINT,
    cache: Cache = None,
) -> None:
    """Print how far networks are from the machine's peak, by operator, as Markdown.

    Exit codes: 0 all done, 2 wrong usage, 3 problem with a model.
    """
    with explained("bench"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge_bench.latency.benchmark import select_backends
        from footprints_edge_bench.latency.machine import machine
        from footprints_edge_bench.latency.roofline import roofline as find_roofline
        from footprints_edge_bench.model_files.model_cache import ModelCache, default_folder

        rows = select_backends(only or (), model or (), [_size(text) for text in size or ()])
        found = find_roofline(
            [row for row in rows if row.engine == "onnxruntime"],
            ModelCache(cache or default_folder(), edge_checkpoint),
            machine(),
            threads=threads or usable_cores(),
            trials=trials,
        )
        if output is not None:
            output.write_text(found.as_json(), encoding="utf-8")
        typer.echo(found.as_markdown(), nl=False)


class Architecture(StrEnum):
    """Networks that the exporter knows."""

    EDGE = "edge"
    REFERENCE = "reference"


class Precision(StrEnum):
    """Of a file."""

    FP32 = "fp32"
    INT8 = "int8"


@app.command("passes")
def passes_command(
    *,
    network: Annotated[Architecture, typer.Option()] = Architecture.REFERENCE,
    precision: Annotated[Precision, typer.Option()] = Precision.INT8,
    size: Annotated[str, typer.Option(metavar="HxW")] = "192x640",
    threads: Threads = None,
    trials: Annotated[int, typer.Option(min=2, help="Timed frames of each file.")] = 30,
    checkpoint: Annotated[
        Path | None, typer.Option(help="Trained weights: print what changes in their maps instead.")
    ] = None,
    photos: Annotated[
        list[Path] | None,
        typer.Option(help="With --checkpoint: folder of photos; repeat for more."),
    ] = None,
) -> None:
    """Print what each graph pass gains, on random weights, as Markdown.

    Exit codes: 0 all done, 2 wrong usage, 3 problem with a model.
    """
    if (checkpoint is None) != (not photos):
        raise typer.BadParameter("--checkpoint and --photos go together")
    with explained("bench"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge_bench.passes.gains import gains_as_markdown, measure_gains
        from footprints_edge_bench.passes.map_changes import changes_as_markdown, measure_changes

        count = threads or usable_cores()
        if checkpoint is not None:
            changes = measure_changes(
                network.value, checkpoint, precision.value, _size(size), photos or (), count
            )
            typer.echo(changes_as_markdown(changes), nl=False)
            return
        gains = measure_gains(network.value, precision.value, _size(size), count, trials)
        typer.echo(gains_as_markdown(gains), nl=False)


def main() -> None:
    """Entry point of ``fp-bench``."""
    app()


def _ids(text: str, option: str) -> tuple[int, ...]:
    """Class ids from text such as ``3,4``."""
    try:
        return tuple(int(part) for part in text.replace(",", " ").split())
    except ValueError:
        raise typer.BadParameter(f"{option} {text!r}: give class ids, such as 3,4") from None


def _size(text: str) -> tuple[int, int]:
    """(H, W) from text such as ``192x640``."""
    try:
        height, width = (int(side) for side in text.lower().split("x"))
    except ValueError:
        raise typer.BadParameter(f"--size {text!r}: give HxW, such as 192x640") from None
    if min(height, width) < 64 or height % 32 or width % 32:
        raise typer.BadParameter(f"--size {text}: both sides must be multiples of 32, from 64 on")
    return height, width


if __name__ == "__main__":
    main()
