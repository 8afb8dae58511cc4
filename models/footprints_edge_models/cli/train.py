"""``fp-train edge`` and ``fp-train reference``: train a network."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from footprints_edge.cli.exit_codes import complain, explained
from footprints_edge_models.cli.options import (
    Batch,
    Data,
    Device,
    Init,
    Schedule,
    Seed,
    device_of,
    recipe_of,
)

if TYPE_CHECKING:
    from footprints_edge_models.training.recipe import Recipe

DEFAULT_SCHEDULE = ("128x224:2400", "192x320:1600", "256x448:700")

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
    hidden_weight: Annotated[
        float, typer.Option(help="Weight of hidden ground in the loss of S* (eq. 3a).")
    ] = 1.0,
    footprint_weight: Annotated[
        float, typer.Option(help="Weight of footprints in the loss of S* (eq. 3b).")
    ] = 3.0,
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
        )
        typer.echo(_train(data, recipe, run, device))


def reference(
    data: Data,
    run: Run,
    schedule: Schedule = ["128x224:2400"],  # noqa: B006  (typer copies it)
    batch: Batch = 12,
    seed: Seed = 0,
    init: Annotated[
        Path | None, typer.Option(help="Initial weights; default: random weights.")
    ] = None,
    device: Device = "auto",
) -> None:
    """Train the paper's network in the same way; print the path of its weights.

    Its depths are for a canonical camera, whose focal length is printed at the end.
    """
    with explained("train"):
        from footprints_edge_models.networks.edge import focal_px_at

        recipe = recipe_of(schedule, batch, seed, init, network="reference")
        weights = _train(data, recipe, run, device)
        focal_px = focal_px_at(recipe.schedule[-1].size)
        complain(f"Convert them with --arch reference --focal-px {focal_px:g}")
        typer.echo(weights)


def _train(data: Path, recipe: "Recipe", run: Path, device: str) -> Path:
    """Trains behind a progress bar; the path of the weights."""
    from tqdm import tqdm

    from footprints_edge_models.data.mixture import load_datasets
    from footprints_edge_models.training.trainer import train

    where = device_of(device)
    datasets = load_datasets(data)
    with tqdm(unit="step", disable=None) as bar:

        def progress(step: int, steps: int, loss: float) -> None:
            bar.total = steps
            bar.set_postfix(loss=f"{loss:.3f}", refresh=False)
            bar.update(step - bar.n)

        return train(datasets, recipe, run, device=where, progress=progress)
