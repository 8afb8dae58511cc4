"""Options that several commands share, and what they stand for."""

import os
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    import torch

    from footprints_edge_models.data.mixture import TrainingDataset
    from footprints_edge_models.training.recipe import Recipe

Data = Annotated[
    Path, typer.Argument(help="Folder of the datasets (see docs/data.md), or a packed one.")
]
Schedule = Annotated[
    list[str],
    typer.Option(metavar="HxW:STEPS", help="Image size and number of steps; repeat for stages."),
]
Batch = Annotated[int, typer.Option(min=1, help="Batch size.")]
Seed = Annotated[int, typer.Option(help="Random seed of weights and data.")]
Init = Annotated[
    Path | None, typer.Option(help="Initial weights; default: an ImageNet-pretrained encoder.")
]
HiddenWeight = Annotated[
    float, typer.Option(help="Weight of hidden ground in the loss of S* (eq. 3a).")
]
FootprintWeight = Annotated[
    float, typer.Option(help="Weight of footprints in the loss of S* (eq. 3b).")
]
RelativeDepth = Annotated[
    float, typer.Option(help="Weight of the relative depth loss beside the paper's.")
]
Dice = Annotated[float, typer.Option(help="Weight of the soft Dice loss of both masks.")]
CoarseDecoder = Annotated[
    bool,
    typer.Option(
        "--coarse-decoder",
        help="Add a second, coarse decoder: 1.2 times the time. Initial weights may have it.",
    ),
]
FrozenStages = Annotated[
    int, typer.Option(help="First stages of the encoder that do not learn, 0 to 7: faster.")
]
Device = Annotated[str, typer.Option(help="cpu, cuda, or auto for cuda where there is one.")]
Jobs = Annotated[
    int | None,
    typer.Option("-j", "--jobs", min=1, help="Number of processes; default: one per core."),
]


class NetworkName(StrEnum):
    """Networks that there are weights of."""

    EDGE = "edge"
    REFERENCE = "reference"


class JobEngine(StrEnum):
    """Where a job runs."""

    LOCAL = "local"
    RAY = "ray"


Engine = Annotated[
    JobEngine, typer.Option(help="This machine's cores, or Ray (the cluster of RAY_ADDRESS).")
]


class Balance(StrEnum):
    """How pixels of S* are weighed against each other."""

    NONE = "none"
    CLASSES = "classes"
    FOCAL = "focal"


BalanceOfPixels = Annotated[
    Balance, typer.Option(help="How pixels of S* are weighed against each other.")
]


def recipe_of(
    schedule: list[str],
    batch: int,
    seed: int,
    init: Path | None,
    **more: Any,  # noqa: ANN401  (fields of Recipe)
) -> "Recipe":
    """The recipe that the options ask for."""
    from footprints_edge_models.training.recipe import Recipe
    from footprints_edge_models.training.schedule import ScheduleStage

    stages = tuple(ScheduleStage.parse(text) for text in schedule)
    weights = None if init is None else str(init)
    return Recipe(stages, batch=batch, seed=seed, init=weights, **more)


def has_coarse_decoder(asked: bool, init: Path | None) -> bool:
    """Whether the network to train has a coarse decoder: asked for, or in its initial weights."""
    from footprints_edge_models.networks import edge
    from footprints_edge_models.networks.checkpoint import read_checkpoint

    return asked or (init is not None and edge.has_coarse_decoder(read_checkpoint(init)))


def datasets_of(data: Path) -> "dict[str, TrainingDataset]":
    """The datasets of a folder, packed or not."""
    from footprints_edge_models.data.packed import datasets_in

    return datasets_in(data)


def device_of(name: str) -> "torch.device":
    """The device that ``--device`` names.

    Raises:
        TrainingError: it is not there.
    """
    import torch

    from footprints_edge_models.training.schedule import TrainingError

    if name == "auto":
        name = "cuda" if torch.cuda.is_available() else "cpu"
    if name != "cpu" and not (name.startswith("cuda") and torch.cuda.is_available()):
        raise TrainingError(f"device {name!r}: here only cpu and, where there is one, cuda")
    if name == "cuda" and "LOCAL_RANK" in os.environ:  # one of the processes that torchrun starts
        name = f"cuda:{os.environ['LOCAL_RANK']}"
    return torch.device(name)


def size_of(text: str) -> tuple[int, int]:
    """(H, W) of the option ``--size``.

    Raises:
        typer.BadParameter: it is no size.
    """
    from footprints_edge.foundation.size_text import parse_size

    try:
        return parse_size(text)
    except ValueError as error:
        raise typer.BadParameter(f"--size: {error}") from None
