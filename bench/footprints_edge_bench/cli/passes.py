"""``fp-bench passes``."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_bench.cli.options import Threads, network_size


class NetworkOption(StrEnum):
    """Networks that the exporter knows."""

    EDGE = "edge"
    REFERENCE = "reference"


class PrecisionOption(StrEnum):
    """Precisions with graph passes."""

    FP32 = "fp32"
    INT8 = "int8"


def passes_command(
    *,
    network: Annotated[
        NetworkOption, typer.Option(help="Network to export.")
    ] = NetworkOption.REFERENCE,
    precision: Annotated[
        PrecisionOption, typer.Option(help="Precision of the graph.")
    ] = PrecisionOption.INT8,
    size: Annotated[str, typer.Option(metavar="HxW", help="Input size.")] = "192x640",
    threads: Threads = None,
    trials: Annotated[int, typer.Option(min=2, help="Timed frames per graph.")] = 30,
    checkpoint: Annotated[
        Path | None,
        typer.Option(help="Trained weights: compare maps instead of times; needs --photos."),
    ] = None,
    photos: Annotated[
        list[Path] | None,
        typer.Option(help="Folder of photos to compare maps on; repeatable; needs --checkpoint."),
    ] = None,
) -> None:
    """Measure the effect of each graph pass.

    Prints the speed-up of each pass, with calibrated random weights, as Markdown; with
    --checkpoint, how much the passes change the maps.

    Exit codes: 0 done, 2 usage error, 3 model problem.
    """
    if (checkpoint is None) != (not photos):
        raise typer.BadParameter("give --checkpoint and --photos together, or neither")
    with explained("bench"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge_bench.passes.gains import gains_as_markdown, measure_gains
        from footprints_edge_bench.passes.map_changes import changes_as_markdown, measure_changes

        count, shape = threads or usable_cores(), network_size(size)
        if checkpoint is None:
            gains = measure_gains(network.value, precision.value, shape, count, trials)
            typer.echo(gains_as_markdown(gains), nl=False)
            return
        changes = measure_changes(
            network.value, checkpoint, precision.value, shape, photos or (), count
        )
        typer.echo(changes_as_markdown(changes), nl=False)
