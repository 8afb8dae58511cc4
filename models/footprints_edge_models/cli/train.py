"""``fp-train edge`` and ``fp-train reference``: train a network."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_models.cli.options import (
    Balance,
    BalanceOfPixels,
    Batch,
    CoarseDecoder,
    Data,
    Device,
    Dice,
    FootprintWeight,
    FrozenStages,
    HiddenWeight,
    Init,
    RelativeDepth,
    Schedule,
    Seed,
    datasets_of,
    device_of,
    has_coarse_decoder,
    recipe_of,
)

if TYPE_CHECKING:
    from footprints_edge_models.training.progress import Progress
    from footprints_edge_models.training.recipe import Recipe

DEFAULT_SCHEDULE = ("128x224:2400", "192x320:1600", "256x448:700")


Decay = Annotated[
    float, typer.Option(help="Share of the run, at its end, over which the rates fall to zero.")
]
Minutes = Annotated[
    float | None,
    typer.Option(help="End after so many minutes; the last stage goes on until then."),
]
DecayFrom = Annotated[
    Path | None,
    typer.Option(
        metavar="RUN",
        help="Go on from the checkpoint of another run; with --decay 1, finish its weights.",
    ),
]
Workers = Annotated[
    int | None,
    typer.Option(
        min=0,
        help="Processes that prepare pictures.  [default: one per core for a GPU, else threads]",
    ),
]
Run = Annotated[Path, typer.Option(help="Folder of the run; an unfinished run is resumed.")]


def edge(
    data: Data,
    run: Run,
    schedule: Schedule = list(DEFAULT_SCHEDULE),  # noqa: B006  (typer copies it)
    batch: Batch = 12,
    seed: Seed = 0,
    init: Init = None,
    lr_scale: Annotated[
        float, typer.Option(help="Scale all learning rates; use less than 1 to fine-tune.")
    ] = 1.0,
    lambda_unknown: Annotated[
        float, typer.Option(help="The paper's lambda: weight of unknown pixels (eq. 3c).")
    ] = 0.25,
    footprint_masks: Annotated[
        bool, typer.Option(help="Learn from untraversable pixels (eq. 3b), or treat as unknown.")
    ] = True,
    moving_objects: Annotated[
        bool, typer.Option(help="Ignore the ground behind moving objects, or learn from it.")
    ] = True,
    hidden_weight: HiddenWeight = 1.0,
    footprint_weight: FootprintWeight = 3.0,
    balance: BalanceOfPixels = Balance.NONE,
    relative_depth: RelativeDepth = 0.0,
    dice: Dice = 0.0,
    coarse_decoder: CoarseDecoder = False,
    frozen_stages: FrozenStages = 0,
    decay: Decay = 0.2,
    minutes: Minutes = None,
    decay_from: DecayFrom = None,
    workers: Workers = None,
    device: Device = "auto",
) -> None:
    """Train the edge network on every dataset found in DATA; print the path of its weights."""
    with explained("train"):
        recipe = recipe_of(
            schedule,
            batch,
            seed,
            init,
            lr_scale=lr_scale,
            lambda_unknown=lambda_unknown,
            footprint_masks=footprint_masks,
            moving_objects=moving_objects,
            hidden_weight=hidden_weight,
            footprint_weight=footprint_weight,
            balance=balance.value,
            relative_depth=relative_depth,
            dice=dice,
            coarse_decoder=has_coarse_decoder(coarse_decoder, init),
            frozen_stages=frozen_stages,
            decay=decay,
            minutes=minutes,
            decay_from=None if decay_from is None else str(decay_from),
        )
        typer.echo(_train(data, recipe, run, device, workers))


def reference(
    data: Data,
    run: Run,
    schedule: Schedule = ["128x224:2400"],  # noqa: B006  (typer copies it)
    batch: Batch = 12,
    seed: Seed = 0,
    init: Annotated[
        Path | None, typer.Option(help="Initial weights; default: random weights.")
    ] = None,
    decay: Decay = 0.2,
    minutes: Minutes = None,
    decay_from: DecayFrom = None,
    workers: Workers = None,
    device: Device = "auto",
) -> None:
    """Train the paper's network in the same way; print the path of its weights."""
    with explained("train"):
        recipe = recipe_of(
            schedule,
            batch,
            seed,
            init,
            network="reference",
            decay=decay,
            minutes=minutes,
            decay_from=None if decay_from is None else str(decay_from),
        )
        typer.echo(_train(data, recipe, run, device, workers))


def _train(data: Path, recipe: "Recipe", run: Path, device: str, workers: int | None) -> Path:
    """Trains behind a progress bar; the path of the weights."""
    from tqdm import tqdm

    from footprints_edge_models.training.trainer import train

    where = device_of(device)
    if workers is None:  # a GPU is faster than two threads; torchrun's processes share the cores
        cores = len(os.sched_getaffinity(0)) // int(os.environ.get("LOCAL_WORLD_SIZE", "1"))
        workers = 0 if where.type == "cpu" else max(1, cores)
    datasets = datasets_of(data)
    is_first = os.environ.get("RANK", "0") == "0"  # torchrun starts others as well
    with tqdm(bar_format="{desc}", disable=None if is_first else True) as bar:

        def progress(now: "Progress") -> None:
            bar.set_description_str(str(now))

        return train(datasets, recipe, run, device=where, workers=workers, progress=progress)
