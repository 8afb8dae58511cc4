"""``fp-train gpu-kit``: a folder to train with on a machine with a GPU and no network."""

import json
from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_models.cli.options import (
    Balance,
    BalanceOfPixels,
    CoarseDecoder,
    Data,
    Dice,
    FootprintWeight,
    FrozenStages,
    HiddenWeight,
    Init,
    RelativeDepth,
    Seed,
    has_coarse_decoder,
    size_of,
)


def gpu_kit(
    data: Data,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of the kit.")],
    assets: Annotated[
        Path | None,
        typer.Option(exists=True, dir_okay=False, help="Pack made by fp-train assets."),
    ] = None,
    max_mb: Annotated[float, typer.Option(min=1, help="Most megabytes of the kit.")] = 55.0,
    init: Init = None,
    size: Annotated[
        str, typer.Option(metavar="HxW", help="Size of a batch of landscape views.")
    ] = "256x448",
    hidden_weight: HiddenWeight = 5.0,
    footprint_weight: FootprintWeight = 5.0,
    balance: BalanceOfPixels = Balance.NONE,
    relative_depth: RelativeDepth = 0.0,
    dice: Dice = 0.0,
    coarse_decoder: CoarseDecoder = False,
    frozen_stages: FrozenStages = 0,
    seed: Seed = 0,
    research: Annotated[
        bool, typer.Option(help="Also take data whose licence allows research alone.")
    ] = False,
    wheels: Annotated[
        Path | None,
        typer.Option(
            exists=True,
            file_okay=False,
            help="Folder of wheels for Python 3.12 that the machine lacks; default: pip downloads.",
        ),
    ] = None,
) -> None:
    """Pack code, data and assets for minutes of training; print the bytes of its parts as JSON.

    On the machine: python FOLDER/run.py --minutes 9 --out RESULTS
    """
    with explained("train"):
        from footprints_edge_models.training.gpu_kit.folder import build_kit
        from footprints_edge_models.training.gpu_kit.kit_settings import KitSettings

        recipe = {
            "hidden_weight": hidden_weight,
            "footprint_weight": footprint_weight,
            "balance": balance.value,
            "relative_depth": relative_depth,
            "dice": dice,
            "coarse_decoder": has_coarse_decoder(coarse_decoder, init),
            "frozen_stages": frozen_stages,
        }
        settings = KitSettings(size_of(size), {}, seed, recipe)
        sizes = build_kit(
            output,
            data,
            Path(__file__).with_name("run_kit.py"),
            settings,
            assets=assets,
            init=init,
            most_bytes=int(max_mb * 1e6),
            research=research,
            wheels=wheels,
        )
        typer.echo(json.dumps({"kit": str(output), **sizes, "bytes": sum(sizes.values())}))
