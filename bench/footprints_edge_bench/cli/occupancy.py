"""``fp-bench occupancy``."""

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_bench.cli.options import Every, ExactData, Frames, HeldOut, Models
from footprints_edge_bench.cli.progress import progress_bar


def occupancy_command(
    data: ExactData,
    *,
    models: Models = None,
    frames: Frames = "0:1",
    held_out: HeldOut = False,
    every: Every = 1,
) -> None:
    """Compare occupancy grids with those of exact maps.

    Grids are in metres. Prints a table as Markdown.

    Exit codes: 0 done, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge_bench.accuracy.benchmark import open_benchmark
        from footprints_edge_bench.ground_truth.datasets import Subset
        from footprints_edge_bench.navigation.occupancy import as_markdown, score_grids

        benchmark = open_benchmark(data, Subset.parse(frames, every, held_out=held_out), models)
        with progress_bar(len(benchmark.items()), "image") as progress:
            scores = score_grids(benchmark, progress)
        typer.echo(as_markdown(scores), nl=False)
