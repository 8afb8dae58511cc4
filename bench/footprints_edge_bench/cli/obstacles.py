"""``fp-bench obstacles``."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_bench.cli.options import Every, Frames, HeldOut, Models
from footprints_edge_bench.cli.progress import progress_bar


def obstacles_command(
    data: Annotated[
        list[Path],
        typer.Argument(help="Folders with measured or exact depth: RGB-D clips, synthetic scenes."),
    ],
    *,
    models: Models = None,
    frames: Frames = "0:1",
    held_out: HeldOut = False,
    every: Every = 1,
) -> None:
    """Score the distance to the nearest obstacle by bearing.

    Measured depth is the truth. The camera's intrinsics are the true ones, its pose is not given.
    Prints a table as Markdown.

    Exit codes: 0 done, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge_bench.accuracy.benchmark import open_benchmark
        from footprints_edge_bench.ground_truth.datasets import Subset
        from footprints_edge_bench.navigation.obstacles import as_markdown, score_obstacles

        benchmark = open_benchmark(data, Subset.parse(frames, every, held_out=held_out), models)
        with progress_bar(len(benchmark.items()), "image") as progress:
            scores = score_obstacles(benchmark, progress)
        typer.echo(as_markdown(scores), nl=False)
