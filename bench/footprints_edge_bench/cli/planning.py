"""``fp-bench planning``."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import SOME_FAILED, explained
from footprints_edge_bench.cli.options import Every, Frames, HeldOut, Models
from footprints_edge_bench.cli.progress import progress_bar


def planning_command(
    data: Annotated[
        list[Path],
        typer.Argument(
            help="Folders with ground truth of hidden ground: RGB-D clips, synthetic scenes."
        ),
    ],
    *,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder of planning.md and planning.csv.")
    ] = Path("planning"),
    models: Models = None,
    paths: Annotated[
        int, typer.Option(min=1, help="Number of paths per image; the paper uses 1.")
    ] = 5,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the start and goal points.")] = 0,
    frames: Frames = "0:1",
    held_out: HeldOut = False,
    every: Every = 1,
) -> None:
    """Score path planning to hidden ground.

    Plans paths over the ground of each method. Prints the paper's table as Markdown.

    Exit codes: 0 done, 1 some images failed, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge.navigation.path_planning import require_graph_search
        from footprints_edge_bench.accuracy.benchmark import open_benchmark
        from footprints_edge_bench.ground_truth.datasets import Subset
        from footprints_edge_bench.navigation.path_planning import plan_paths, write_reports

        require_graph_search()
        benchmark = open_benchmark(data, Subset.parse(frames, every, held_out=held_out), models)
        with progress_bar(len(benchmark.items()), "image") as progress:
            scores, failures = plan_paths(benchmark, paths, seed, progress)
        typer.echo(write_reports(benchmark, scores, failures, paths, output), nl=False)
        if failures:
            raise typer.Exit(SOME_FAILED)
