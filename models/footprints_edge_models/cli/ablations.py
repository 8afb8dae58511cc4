"""``fp-train ablations``: the paper's ablations of the loss."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_models.cli.options import (
    Batch,
    Data,
    Device,
    Init,
    Schedule,
    Seed,
    datasets_of,
    device_of,
    recipe_of,
)

if TYPE_CHECKING:
    from footprints_edge_models.training.progress import Progress


def ablations(
    data: Data,
    run: Annotated[Path, typer.Option(help="Folder of the runs; unfinished runs are resumed.")],
    schedule: Schedule = ["128x224:600"],  # noqa: B006  (typer copies it)
    batch: Batch = 12,
    seed: Seed = 0,
    init: Init = None,
    device: Device = "auto",
) -> None:
    """Train the paper's ablations of the loss; print tables of their held-out scores."""
    with explained("train"):
        from tqdm import tqdm

        from footprints_edge_models.training.ablations import ABLATIONS, train_ablations

        where = device_of(device)
        recipe = recipe_of(schedule, batch, seed, init)
        datasets = datasets_of(data)
        with tqdm(total=len(ABLATIONS) * recipe.steps, unit="step", disable=None) as bar:

            def progress(name: str, now: "Progress") -> None:
                bar.set_postfix_str(f"{name}, loss {now.loss:.3f}", refresh=False)
                bar.update(list(ABLATIONS).index(name) * recipe.steps + now.step - bar.n)

            tables = train_ablations(datasets, recipe, run, device=where, progress=progress)
        typer.echo(tables)
