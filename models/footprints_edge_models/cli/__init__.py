"""``fp-train``: training data and training."""

import logging
import sys

import typer

from footprints_edge.cli.common_options import HELP, VersionOption
from footprints_edge_models.cli.ablations import ablations
from footprints_edge_models.cli.assets import assets
from footprints_edge_models.cli.average import average
from footprints_edge_models.cli.calibrate import calibrate
from footprints_edge_models.cli.gpu_kit import gpu_kit
from footprints_edge_models.cli.insert import insert
from footprints_edge_models.cli.labels import labels
from footprints_edge_models.cli.pack import pack
from footprints_edge_models.cli.panoramas import panoramas
from footprints_edge_models.cli.photos import photos
from footprints_edge_models.cli.scenes import scenes
from footprints_edge_models.cli.train import edge, reference

app = typer.Typer(
    name="fp-train",
    help="Train the networks of footprints-edge.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings=HELP,
)


@app.callback()
def _root(_version: VersionOption = False) -> None:
    """Train the networks of footprints-edge."""


for command in (
    *(edge, reference, ablations, calibrate, average, pack, gpu_kit),
    *(labels, scenes, assets, panoramas, photos, insert),
):
    app.command()(command)


def main() -> None:
    """Entry point of ``fp-train``."""
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
    app()
