"""``fp-train calibrate``: thresholds of 0.5 made right again."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import complain, explained
from footprints_edge_models.cli.options import NetworkName, datasets_of, size_of


def calibrate(
    weights: Annotated[Path, typer.Argument(help="Weights to calibrate, a state dict.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Weights to write.")],
    data: Annotated[
        Path | None,
        typer.Argument(help="Folder of the datasets (see docs/data.md), or a packed one."),
    ] = None,
    on: Annotated[
        list[Path] | None,
        typer.Option(
            exists=True,
            file_okay=False,
            help="Folder of one dataset, or of photos with hand-drawn ground (truth.json), in "
            "place of DATA; repeat for more.",
        ),
    ] = None,
    arch: Annotated[NetworkName, typer.Option(help="Network of the weights.")] = NetworkName.EDGE,
    size: Annotated[str, typer.Option(metavar="HxW", help="Size of the pictures.")] = "256x448",
) -> None:
    """Fit temperature and bias of both masks of WEIGHTS on held-out pictures.

    Prints a line per mask: the fit is to one half of the pictures, what it gains is measured on the
    other. Both go into the last convolution: the network stays as large and fast.
    """
    with explained("train"):
        from footprints_edge_models.networks.checkpoint import (
            load_weights,
            read_checkpoint,
            stated_focal_px,
        )
        from footprints_edge_models.networks.registry import NETWORKS
        from footprints_edge_models.training.calibration import calibrate as calibrated
        from footprints_edge_models.training.calibration_data import halved, halves_of
        from footprints_edge_models.training.run_files import save_weights
        from footprints_edge_models.training.weight_credits import stated_credits

        if (data is None) == (not on):
            raise typer.BadParameter("name DATA or --on, one of them: what to calibrate on")
        checkpoint = read_checkpoint(weights)
        spec = NETWORKS[arch]
        network = spec.build_for(checkpoint).eval()
        load_weights(network, checkpoint, str(weights))
        halves = [halves_of(folder) for folder in on or ()]
        if data is not None:
            halves = [halved(dataset) for dataset in datasets_of(data).values()]
        samples, others = ([s for half in each for s in half] for each in zip(*halves, strict=True))
        found = calibrated(network, samples, others, size_of(size))
        focal_px = stated_focal_px(checkpoint, str(weights)) or spec.focal_px
        save_weights(network, focal_px, output, stated_credits(checkpoint, str(weights)))
        for mask, fit in zip(("visible ground", "ground"), found, strict=True):
            complain(
                f"{mask}: logits times {fit.scale:.3f}, plus {fit.bias:+.3f}; cross-entropy "
                f"{fit.before:.4f}, now {fit.after:.4f}, on {len(others)} other pictures"
            )
        typer.echo(output)
