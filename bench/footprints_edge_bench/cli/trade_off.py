"""``fp-bench trade-off``."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_bench.cli.options import Threads
from footprints_edge_bench.cli.progress import progress_bar


def trade_off_command(
    data: Annotated[
        list[Path],
        typer.Argument(help="Folders with ground truth of hidden ground; see docs/accuracy.md."),
    ],
    *,
    models: Annotated[
        list[str] | None,
        typer.Option(
            "--model",
            help="Model file, or a name from fp-models list; repeatable.  [default: every name]",
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Draw the plot to this PNG.")
    ] = None,
    threads: Threads = None,
    trials: Annotated[int, typer.Option(min=2, help="Timed frames of each model.")] = 40,
) -> None:
    """Plot the accuracy of models against their time.

    Accuracy is the mean of freespace and footprint IoU over all datasets; time is that of the
    network alone, all models in turns. Prints a table as Markdown.

    Exit codes: 0 done, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge.model_files.registry import bundled_models
        from footprints_edge_bench.accuracy.benchmark import open_benchmark
        from footprints_edge_bench.engines.backend import BackendSetting
        from footprints_edge_bench.ground_truth.datasets import Subset
        from footprints_edge_bench.latency.machine import machine
        from footprints_edge_bench.latency.trade_off import trade_off
        from footprints_edge_bench.model_files.model_cache import ModelCache, default_folder

        facts = machine()
        benchmark = open_benchmark(
            data, Subset(), models or [each.name for each in bundled_models()]
        )
        setting = BackendSetting(ModelCache(default_folder()), threads or usable_cores())
        steps = len(benchmark.items()) + trials * len(benchmark.models)
        with progress_bar(steps, "step") as progress:
            found = trade_off(benchmark, setting, facts, trials, progress)
        typer.echo(found.as_markdown(), nl=False)
        if output is not None:
            output.parent.mkdir(parents=True, exist_ok=True)
            found.draw(output)
