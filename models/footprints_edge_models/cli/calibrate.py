"""``fp-train calibrate``: thresholds of 0.5 made right again."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import complain, explained
from footprints_edge_models.cli.options import Data, datasets_of, size_of


class NetworkName(StrEnum):
    """Networks that can be calibrated."""

    EDGE = "edge"
    REFERENCE = "reference"


def calibrate(
    weights: Annotated[Path, typer.Argument(help="Weights to calibrate, a state dict.")],
    data: Data,
    output: Annotated[Path, typer.Option("-o", "--output", help="Weights to write.")],
    arch: Annotated[NetworkName, typer.Option(help="Network of the weights.")] = NetworkName.EDGE,
    size: Annotated[str, typer.Option(metavar="HxW", help="Size of the pictures.")] = "256x448",
) -> None:
    """Fit temperature and bias of both masks of WEIGHTS on the held-out pictures of DATA.

    Prints a line per mask. Both go into the last convolution: the network stays as large and fast.
    """
    with explained("train"):
        from footprints_edge_models.networks.checkpoint import (
            load_weights,
            read_checkpoint,
            stated_focal_px,
        )
        from footprints_edge_models.networks.registry import NETWORKS
        from footprints_edge_models.training.calibration import calibrate as calibrated
        from footprints_edge_models.training.run_files import save_weights
        from footprints_edge_models.training.validation import spread

        checkpoint = read_checkpoint(weights)
        spec = NETWORKS[arch]
        network = spec.build().eval()
        load_weights(network, checkpoint, str(weights))
        datasets = datasets_of(data)
        samples = [s for dataset in datasets.values() for s in spread(dataset.held_out)]
        found = calibrated(network, samples, size_of(size))
        save_weights(network, stated_focal_px(checkpoint, str(weights)) or spec.focal_px, output)
        for mask, fit in zip(("visible ground", "ground"), found, strict=True):
            complain(
                f"{mask}: logits times {fit.scale:.3f}, plus {fit.bias:+.3f}; cross-entropy "
                f"{fit.before:.4f}, now {fit.after:.4f}"
            )
        typer.echo(output)
