"""``fp-bench accuracy``."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import SOME_FAILED, complain, explained
from footprints_edge_bench.cli.options import Every, Frames, HeldOut, Models, class_ids
from footprints_edge_bench.cli.progress import progress_bar


def accuracy_command(
    data: Annotated[
        list[Path],
        typer.Argument(
            help="Folders of RGB-D clips, synthetic scenes, labelled photos, KITTI or Matterport "
            "ground truth; see docs/accuracy.md."
        ),
    ],
    *,
    output: Annotated[
        Path,
        typer.Option("-o", "--output", help="Folder of the results; resumes an interrupted run."),
    ] = Path("accuracy"),
    models: Models = None,
    images: Annotated[
        Path | None,
        typer.Option(help="Images of KITTI or Matterport: a folder, or KITTI's list of the split."),
    ] = None,
    walkable: Annotated[
        str, typer.Option(metavar="ID,…", help="Class ids of ground in labelled photos.")
    ] = "",
    void: Annotated[
        str, typer.Option(metavar="ID,…", help="Class ids in labelled photos that are not scored.")
    ] = "",
    frames: Frames = "0:1",
    held_out: HeldOut = False,
    every: Every = 1,
    boxes: Annotated[
        Path | None, typer.Option(help="JSON file of oriented boxes, for the box baseline.")
    ] = None,
    voxels: Annotated[
        Path | None, typer.Option(help="Folder of voxel grids, for the voxel baselines.")
    ] = None,
    unflattened: Annotated[
        bool,
        typer.Option(
            "--unflattened",
            help="Also score the ground depth before it is laid onto the ground plane.",
        ),
    ] = False,
    fresh: Annotated[bool, typer.Option("--fresh", help="Discard the results of earlier runs.")] = (
        False
    ),
) -> None:
    """Score models and the paper's baselines.

    Prints the tables as Markdown.

    Exit codes: 0 done, 1 some images failed, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge_bench.accuracy.benchmark import evaluate, open_benchmark
        from footprints_edge_bench.accuracy.report import write_reports
        from footprints_edge_bench.accuracy.results import Results
        from footprints_edge_bench.ground_truth.datasets import ReadingOptions, Subset

        benchmark = open_benchmark(
            data,
            Subset.parse(frames, every, held_out=held_out),
            models,
            reading=ReadingOptions(
                images, class_ids(walkable, "--walkable"), class_ids(void, "--void")
            ),
            boxes_file=boxes,
            voxels=voxels,
            unflattened=unflattened,
        )
        results = Results(output / "results.jsonl", benchmark.settings(), fresh=fresh)
        count = len(benchmark.items())
        with progress_bar(count, "image") as progress:
            failures = evaluate(benchmark, results, progress)
        typer.echo(write_reports(benchmark, results, failures, output), nl=False)
        for name, reason in failures.items():
            complain(f"Skipped {name}: {reason}")
        if failures:
            complain(f"{len(failures)} of {count} images failed.")
            raise typer.Exit(SOME_FAILED)
