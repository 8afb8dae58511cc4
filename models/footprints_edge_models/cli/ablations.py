"""``fp-train ablations``: what each part of the loss and of the network gives."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_models.cli.options import (
    Batch,
    Data,
    Device,
    FootprintWeight,
    FrozenStages,
    HiddenWeight,
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
    on: Annotated[
        list[Path] | None,
        typer.Option(
            exists=True,
            file_okay=False,
            help="Photos with hand-drawn ground (truth.json): scored as well, never trained on.",
        ),
    ] = None,
    schedule: Schedule = ["128x224:600"],  # noqa: B006  (typer copies it)
    batch: Batch = 12,
    seed: Seed = 0,
    hidden_weight: HiddenWeight = 5.0,
    footprint_weight: FootprintWeight = 5.0,
    frozen_stages: FrozenStages = 3,
    device: Device = "auto",
) -> None:
    """Train the paper's ablations of the loss, and ours; print tables of their held-out scores.

    The defaults are what the bundled weights are trained with.
    """
    with explained("train"):
        from tqdm import tqdm

        from footprints_edge_models.data.mixture import TrainingDataset
        from footprints_edge_models.data.readers.hand_drawn import read_hand_drawn
        from footprints_edge_models.training.ablations import ABLATIONS, train_ablations

        where = device_of(device)
        recipe = recipe_of(
            schedule,
            batch,
            seed,
            None,
            hidden_weight=hidden_weight,
            footprint_weight=footprint_weight,
            coarse_decoder=True,
            frozen_stages=frozen_stages,
        )
        datasets = datasets_of(data)
        for folder in map(Path.resolve, on or []):
            datasets[folder.name] = TrainingDataset((), list(read_hand_drawn(folder)), 0.0)
        with tqdm(total=len(ABLATIONS) * recipe.steps, unit="step", disable=None) as bar:

            def progress(name: str, now: "Progress") -> None:
                bar.set_postfix_str(f"{name}, loss {now.loss:.3f}", refresh=False)
                bar.update(list(ABLATIONS).index(name) * recipe.steps + now.step - bar.n)

            tables = train_ablations(datasets, recipe, run, device=where, progress=progress)
        typer.echo(tables)
