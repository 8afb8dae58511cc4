"""``fp-bench known-pose``."""

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_bench.cli.options import Every, ExactData, Frames, HeldOut, OneModel
from footprints_edge_bench.cli.progress import progress_bar


def known_pose_command(
    data: ExactData,
    *,
    model: OneModel = None,
    frames: Frames = "0:1",
    held_out: HeldOut = False,
    every: Every = 1,
) -> None:
    """Score hidden ground by what is known of the pose.

    That is: its depth, with nothing given, the camera's height, its angles, and all of them; and
    the median of predicted / true distance over all ground.
    The intrinsics are the true ones. Prints a table as Markdown.

    Exit codes: 0 done, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge_bench.accuracy.benchmark import open_benchmark
        from footprints_edge_bench.ground_truth.datasets import Subset
        from footprints_edge_bench.navigation.known_pose import as_markdown, score_known_poses

        subset = Subset.parse(frames, every, held_out=held_out)
        benchmark = open_benchmark(data, subset, [model] if model else None)
        with progress_bar(len(benchmark.items()), "image") as progress:
            scores = score_known_poses(benchmark, progress)
        typer.echo(as_markdown(scores), nl=False)
