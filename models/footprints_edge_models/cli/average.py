"""``fp-train average``: the mean of several weights."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_models.cli.options import NetworkName


def average(
    weights: Annotated[
        list[Path], typer.Argument(help="Weights, state dicts of one network: two or more.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="Weights to write.")],
    arch: Annotated[NetworkName, typer.Option(help="Network of the weights.")] = NetworkName.EDGE,
) -> None:
    """Write the mean of WEIGHTS, which should have begun with the same ones; print its path."""
    with explained("train"):
        from footprints_edge_models.networks.registry import NETWORKS
        from footprints_edge_models.training.averaging import mean_of
        from footprints_edge_models.training.run_files import save_weights

        if len(weights) < 2:
            raise typer.BadParameter("name two weights or more: the mean of one is itself")
        spec = NETWORKS[arch]
        network, focal_px, credits = mean_of(weights, spec)
        save_weights(network, focal_px or spec.focal_px, output, credits)
        typer.echo(output)
