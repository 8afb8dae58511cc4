"""The training loop: staged sizes, warm-up and cosine, moving average of weights, resumable."""

import csv
import functools
import logging
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import torch
from torch import nn

from footprints_edge.errors import FootprintsError
from footprints_edge_models.data.datasets import Dataset
from footprints_edge_models.networks.checkpoint import load_weights, read_checkpoint
from footprints_edge_models.networks.edge import EdgeNetwork, pretrained_edge_network
from footprints_edge_models.networks.reference import ReferenceNetwork
from footprints_edge_models.training.batches import batches
from footprints_edge_models.training.losses import LAMBDA, Targets, multiscale_losses
from footprints_edge_models.training.plots import draw_curves, draw_predictions
from footprints_edge_models.training.validation import validate_all

logger = logging.getLogger(__name__)

NETWORKS: dict[str, type[EdgeNetwork | ReferenceNetwork]] = {
    "edge": EdgeNetwork,
    "reference": ReferenceNetwork,
}
"""What can be trained."""


class TrainingError(FootprintsError):
    """A run cannot be started or resumed as asked."""


@dataclass(frozen=True)
class Stage:
    """Some steps at one base size (H, W)."""

    size: tuple[int, int]
    steps: int

    @classmethod
    def parse(cls, text: str) -> "Stage":
        """From ``HxW:STEPS``.

        Raises:
            TrainingError: not of that form, or sides that are no multiples of 32.
        """
        try:
            size, steps = text.split(":")
            height, width = (int(side) for side in size.lower().split("x"))
            stage = cls((height, width), int(steps))
        except ValueError as error:
            raise TrainingError(f"stage {text!r}: write it as HxW:STEPS, 192x320:1800") from error
        if min(height, width) < 32 or height % 32 or width % 32 or stage.steps < 1:
            raise TrainingError(f"stage {text!r}: sides are multiples of 32, steps at least 1")
        return stage


@dataclass(frozen=True)
class Recipe:
    """Everything that decides a run's result, besides the data.

    Attributes:
        stages: in order; small pictures first cost little and teach most.
        batch: pictures a step.
        network: ``edge``, or ``reference``, the paper's own.
        encoder_rate: peak learning rate of an encoder that comes trained.
        decoder_rate: peak learning rate of everything else.
        weight_decay: of AdamW.
        warm_up: steps of linear warm-up, then cosine to zero over all stages.
        average: decay a step of the moving average of weights that is kept.
        seed: of weights and data.
        prior: the paper's lambda (eq. 3c).
        untraversable: learn from pixels known to be untraversable (eq. 3b); without, they are
            unknown ones like the rest.
        moving: leave moving objects out of eq. 3a.
        start: weights to begin with: a state dict's file. Without, the edge network's encoder
            comes from ImageNet, and the reference network starts from nothing.
        peak: of both rates, as a share of what they are above; below 1 to go on from trained
            weights without forgetting them.
    """

    stages: tuple[Stage, ...]
    batch: int = 12
    network: str = "edge"
    encoder_rate: float = 3e-4
    decoder_rate: float = 1e-3
    weight_decay: float = 1e-2
    warm_up: int = 50
    average: float = 0.998
    seed: int = 0
    prior: float = LAMBDA
    untraversable: bool = True
    moving: bool = True
    start: str | None = None
    peak: float = 1.0

    def __post_init__(self) -> None:
        """Refuses an unknown network, a prior outside [0, 1], and a peak outside (0, 1].

        Raises:
            TrainingError: if it is.
        """
        if self.network not in NETWORKS:
            raise TrainingError(f"network {self.network!r}: there are {', '.join(NETWORKS)}")
        if not 0 <= self.prior <= 1:
            raise TrainingError(f"prior {self.prior}: the paper's lambda lies between 0 and 1")
        if not 0 < self.peak <= 1:
            raise TrainingError(f"peak {self.peak}: a share of the learning rates, up to 1")

    def sizes(self) -> list[tuple[int, int]]:
        """The base size of every step."""
        return [stage.size for stage in self.stages for _ in range(stage.steps)]

    def rate(self, step: int) -> float:
        """Learning rate of a step, as a fraction of the full one."""
        total = sum(stage.steps for stage in self.stages)
        if step < self.warm_up:
            return self.peak * (step + 1) / self.warm_up
        done = (step - self.warm_up) / max(1, total - self.warm_up)
        return self.peak * 0.5 * (1 + math.cos(math.pi * done))


def train(
    datasets: dict[str, Dataset],
    recipe: Recipe,
    run: Path,
    *,
    device: torch.device,
    validate_every: int = 500,
    save_every: int = 100,
    progress: Callable[[int, int, float], None] | None = None,
) -> Path:
    """Train a network, or go on where ``run`` stopped.

    Writes ``train.csv``, ``validation.csv``, ``curves.png``, ``predictions.png``, the resumable
    ``last.pt`` and, from every validation on, ``weights.pt``: the moving average, a state dict
    in half precision.

    Args:
        datasets: see :func:`datasets.load_datasets`.
        recipe: what to do.
        run: folder of the run, made if absent.
        device: CPU or CUDA.
        validate_every: steps between validations (one more at the end).
        save_every: steps between resumable checkpoints.
        progress: called with (step, steps, loss) after each step.

    Returns:
        The path of ``weights.pt``.

    Raises:
        TrainingError: the folder holds a run of another recipe.
    """
    run.mkdir(parents=True, exist_ok=True)
    torch.manual_seed(recipe.seed)
    network, comes_trained = _starting_network(recipe)
    network.to(device).to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    optimizer = torch.optim.AdamW(_parameter_groups(network, recipe, comes_trained=comes_trained))
    average = torch.optim.swa_utils.AveragedModel(
        network,
        multi_avg_fn=functools.partial(_moving_average, recipe.average),
        use_buffers=True,
    )
    start = _resume(run, recipe, network, average, optimizer)
    sizes = recipe.sizes()
    network.train()
    if comes_trained:
        _keep_statistics(network.encoder)
    for step, (image, targets) in enumerate(
        batches(datasets, sizes, recipe.batch, recipe.seed, start), start
    ):
        rate = recipe.rate(step)
        for group in optimizer.param_groups:
            group["lr"] = group["peak"] * rate
        image = image.to(device, memory_format=torch.channels_last, non_blocking=True)  # noqa: PLW2901
        # bfloat16 keeps float32's range: no loss scaling; the outputs and losses stay float32.
        with torch.autocast(device.type, torch.bfloat16):
            scales = network.scales(image)
        parts = multiscale_losses(scales, ablated(targets.to(device), recipe))
        optimizer.zero_grad(set_to_none=True)
        parts["loss"].backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(network.parameters(), 5.0)
        optimizer.step()
        average.update_parameters(network)
        values = {name: value.item() for name, value in parts.items()}
        _append(run / "train.csv", {"step": step, **values})
        done = step + 1
        if progress is not None:
            progress(done, len(sizes), values["loss"])
        if done % validate_every == 0 or done == len(sizes):
            _validate(run, done, average.module, datasets, sizes[step])
        if done % save_every == 0 or done == len(sizes):
            state = {
                "step": done,
                "recipe": asdict(recipe),
                "network": network.state_dict(),
                "average": average.state_dict(),
                "optimizer": optimizer.state_dict(),
            }
            _save(state, run / "last.pt")
    return run / "weights.pt"


def ablated(targets: Targets, recipe: Recipe) -> Targets:
    """The targets without what a recipe leaves out (the paper's Table 2), and with its prior."""
    untraversable, prior = targets.untraversable, targets.prior * (recipe.prior / LAMBDA)
    if not recipe.untraversable:
        prior = torch.maximum(prior, recipe.prior * (untraversable > 0))
        untraversable = torch.zeros_like(untraversable)
    moving = targets.moving if recipe.moving else torch.zeros_like(targets.moving)
    return replace(targets, untraversable=untraversable, prior=prior, moving=moving)


def _starting_network(recipe: Recipe) -> tuple[EdgeNetwork | ReferenceNetwork, bool]:
    """The network, and whether its encoder has learned something already."""
    if recipe.start is None and recipe.network == "edge":
        return pretrained_edge_network(), True
    network = NETWORKS[recipe.network]()
    if recipe.start is not None:
        load_weights(network, read_checkpoint(Path(recipe.start)), recipe.start)
    return network, recipe.start is not None


def _keep_statistics(encoder: nn.Module) -> None:
    """Batch norms use the statistics they have: those of a mix of sources are no better.

    What int8 folds into the weights is then what was trained, and a step on a CPU is much faster.
    """
    for module in encoder.modules():
        if isinstance(module, nn.BatchNorm2d):
            module.eval()


def _moving_average(
    decay: float,
    averages: list[torch.Tensor],
    currents: list[torch.Tensor],
    count: torch.Tensor | int,
) -> None:
    """Exponential, but plain at first, so that the fresh weights are soon forgotten; in place."""
    step = int(count)
    weight = 1 - min(decay, (1 + step) / (10 + step))
    for average, current in zip(averages, currents, strict=True):
        if average.is_floating_point():
            average.lerp_(current, weight)
        else:
            average.copy_(current)


def _parameter_groups(
    network: nn.Module, recipe: Recipe, *, comes_trained: bool
) -> list[dict[str, Any]]:
    groups = []
    encoder_rate = recipe.encoder_rate if comes_trained else recipe.decoder_rate
    for is_encoder, peak in ((True, encoder_rate), (False, recipe.decoder_rate)):
        for is_matrix in (True, False):  # norms and biases are not decayed
            parameters = [
                p
                for name, p in network.named_parameters()
                if name.startswith("encoder.") == is_encoder and (p.ndim > 1) == is_matrix
            ]
            decay = recipe.weight_decay if is_matrix else 0.0
            groups.append({"params": parameters, "peak": peak, "lr": 0.0, "weight_decay": decay})
    return groups


def _resume(
    run: Path,
    recipe: Recipe,
    network: nn.Module,
    average: nn.Module,
    optimizer: torch.optim.Optimizer,
) -> int:
    if not (run / "last.pt").exists():
        for name in ("train.csv", "validation.csv"):
            (run / name).unlink(missing_ok=True)
        return 0
    state = read_checkpoint(run / "last.pt")
    if not isinstance(state, dict) or "recipe" not in state:
        raise TrainingError(f"{run / 'last.pt'} is not of a training run; name another folder")
    if {"network": "edge", **state["recipe"]} != asdict(recipe):  # old runs had one network only
        raise TrainingError(
            f"{run} holds a run of another recipe ({state['recipe']}); name another folder"
        )
    network.load_state_dict(state["network"])
    average.load_state_dict(state["average"])
    optimizer.load_state_dict(state["optimizer"])
    for name in ("train.csv", "validation.csv"):  # steps after the checkpoint come again
        _truncate(run / name, state["step"] + (name == "validation.csv"))
    logger.info("%s: going on from step %d", run, state["step"])
    return int(state["step"])


def _validate(
    run: Path, step: int, network: nn.Module, datasets: dict[str, Dataset], size: tuple[int, int]
) -> None:
    for name, scores in validate_all(network, datasets, size).items():
        _append(run / "validation.csv", {"step": step, "dataset": name, **asdict(scores)})
        logger.info("step %d, %s: %s", step, name, scores)
    _save_weights(network, run / "weights.pt")
    draw_curves(run)
    draw_predictions(network, datasets, size, run / "predictions.png")


def _save_weights(network: nn.Module, path: Path) -> None:
    """Half precision: a weight's last bits are noise, and the file is half as large."""
    weights = network.state_dict()
    _save({k: v.half() if v.is_floating_point() else v for k, v in weights.items()}, path)


def _save(state: Any, path: Path) -> None:  # noqa: ANN401
    """Whole or not at all."""
    part = path.with_suffix(".part")
    torch.save(state, part)
    part.replace(path)


def _append(path: Path, row: dict[str, Any]) -> None:
    is_new = not path.exists()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, row)
        if is_new:
            writer.writeheader()
        writer.writerow({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()})


def _truncate(path: Path, step: int) -> None:
    if path.exists():
        header, *rows = path.read_text().splitlines(keepends=True)
        kept = [row for row in rows if int(row.split(",")[0]) < step]
        path.write_text("".join([header, *kept]))
