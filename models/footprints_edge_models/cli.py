"""``fp-train``: training data and training."""

import logging
import sys
from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.endings import explained

app = typer.Typer(
    name="fp-train",
    help="Train the networks of footprints-edge.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=False,
)

DEFAULT_STAGES = ("128x224:2400", "192x320:1600", "256x448:700")


@app.callback()
def _root() -> None:
    """Train the networks of footprints-edge."""


@app.command()
def edge(
    data: Annotated[Path, typer.Argument(help="Folder of the datasets (see CONTRIBUTING.md).")],
    run: Annotated[Path, typer.Option(help="Folder of the run; an unfinished run goes on.")],
    stage: Annotated[
        list[str],
        typer.Option(metavar="HxW:STEPS", help="A size and how long; repeat for more stages."),
    ] = list(DEFAULT_STAGES),  # noqa: B006  (typer copies it)
    batch: Annotated[int, typer.Option(min=1, help="Pictures a step.")] = 12,
    seed: Annotated[int, typer.Option(help="Seed of weights and data.")] = 0,
    device: Annotated[str, typer.Option(help="cpu or cuda; cuda where there is one.")] = "auto",
) -> None:
    """Train the edge network on every dataset found below DATA; prints the path of its weights."""
    with explained("train"):
        import torch
        from tqdm import tqdm

        from .datasets import load_datasets
        from .training import Recipe, Stage, TrainingError, train

        if device == "auto":
            device = "cuda" if torch.cuda.is_available() else "cpu"
        if device != "cpu" and not (device.startswith("cuda") and torch.cuda.is_available()):
            raise TrainingError(f"device {device!r}: here only cpu and, where there is one, cuda")
        recipe = Recipe(tuple(Stage.parse(text) for text in stage), batch=batch, seed=seed)
        datasets = load_datasets(data)
        with tqdm(unit="step", disable=None) as bar:

            def progress(step: int, steps: int, loss: float) -> None:
                bar.total = steps
                bar.set_postfix(loss=f"{loss:.3f}", refresh=False)
                bar.update(step - bar.n)

            weights = train(datasets, recipe, run, device=torch.device(device), progress=progress)
        typer.echo(weights)


def main() -> None:
    """Entry point of ``fp-train``."""
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
    app()


if __name__ == "__main__":
    main()
