"""What a training run does: network, schedule, learning rates, and switches of the loss."""

import math
from dataclasses import asdict, dataclass, replace
from typing import Any

import torch

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.size_text import parse_size
from footprints_edge_models.data.targets import FOOTPRINT_WEIGHT, LAMBDA, Targets
from footprints_edge_models.networks.registry import NETWORKS


class TrainingError(FootprintsError):
    """A run cannot be started or resumed as asked."""


@dataclass(frozen=True)
class ScheduleStage:
    """Some steps at one base size (H, W)."""

    size: tuple[int, int]
    steps: int

    @classmethod
    def parse(cls, text: str) -> "ScheduleStage":
        """From ``HxW:STEPS``.

        Raises:
            TrainingError: not of that form, or sides that are no multiples of 32.
        """
        size_text, _, steps = text.partition(":")
        try:
            stage = cls(parse_size(size_text), int(steps))
        except ValueError as error:
            raise TrainingError(
                f"schedule {text!r}: write it as HxW:STEPS, such as 192x320:1800"
            ) from error
        height, width = stage.size
        if height % 32 or width % 32 or stage.steps < 1:
            raise TrainingError(f"schedule {text!r}: sides are multiples of 32, steps at least 1")
        return stage


@dataclass(frozen=True)
class Recipe:
    """Everything that decides the result of a run, besides the data.

    Attributes:
        schedule: stages in order; small pictures first cost little and teach most.
        batch: pictures per step.
        network: name of the network, a key of ``NETWORKS``.
        encoder_lr: peak learning rate of a pretrained encoder.
        decoder_lr: peak learning rate of everything else.
        weight_decay: weight decay of AdamW.
        warmup_steps: steps of linear warm-up, then cosine to zero over the whole schedule.
        ema_decay: decay per step of the exponential moving average of weights that is kept.
        seed: seed of weights and data.
        lambda_unknown: the paper's lambda, the weight of unknown pixels (eq. 3c).
        footprint_masks: learn from pixels known to be untraversable (eq. 3b); without, they count
            as unknown.
        moving_objects: leave the ground behind moving objects out of eq. 3a.
        hidden_weight: weight of hidden ground in eq. 3a. Such pixels are few, and the paper weighs
            them as all others: then their gradient drowns beside the easy ones.
        footprint_weight: weight of footprints in eq. 3b.
        init: file of the weights to begin with, a state dict; None begins with the network's
            pretrained encoder, or with random weights where it has none.
        lr_scale: factor on both learning rates; below 1 to fine-tune without forgetting.
    """

    schedule: tuple[ScheduleStage, ...]
    batch: int = 12
    network: str = "edge"
    encoder_lr: float = 3e-4
    decoder_lr: float = 1e-3
    weight_decay: float = 1e-2
    warmup_steps: int = 50
    ema_decay: float = 0.998
    seed: int = 0
    lambda_unknown: float = LAMBDA
    footprint_masks: bool = True
    moving_objects: bool = True
    hidden_weight: float = 1.0
    footprint_weight: float = FOOTPRINT_WEIGHT
    init: str | None = None
    lr_scale: float = 1.0

    def __post_init__(self) -> None:
        """Refuses an unknown network and numbers that make no sense.

        Raises:
            TrainingError: if it is.
        """
        if self.network not in NETWORKS:
            raise TrainingError(f"network {self.network!r}: there are {', '.join(NETWORKS)}")
        if not 0 <= self.lambda_unknown <= 1:
            raise TrainingError(
                f"lambda {self.lambda_unknown}: the paper's lambda lies between 0 and 1"
            )
        for name in ("hidden_weight", "footprint_weight"):
            if not 0 < getattr(self, name) < math.inf:
                raise TrainingError(
                    f"{name.replace('_', ' ')} {getattr(self, name)}: give a positive number"
                )
        if not 0 < self.lr_scale <= 1:
            raise TrainingError(
                f"learning-rate scale {self.lr_scale}: give a factor above 0, at most 1"
            )

    def sizes(self) -> list[tuple[int, int]]:
        """The base size of every step."""
        return [stage.size for stage in self.schedule for _ in range(stage.steps)]

    def lr_factor(self, step: int) -> float:
        """Learning rate of a step, as a share of the peak."""
        total = sum(stage.steps for stage in self.schedule)
        if step < self.warmup_steps:
            return self.lr_scale * (step + 1) / self.warmup_steps
        done = (step - self.warmup_steps) / max(1, total - self.warmup_steps)
        return self.lr_scale * 0.5 * (1 + math.cos(math.pi * done))


_FORMER_NAMES = {
    "stages": "schedule",
    "encoder_rate": "encoder_lr",
    "decoder_rate": "decoder_lr",
    "warm_up": "warmup_steps",
    "average": "ema_decay",
    "prior": "lambda_unknown",
    "untraversable": "footprint_masks",
    "moving": "moving_objects",
    "start": "init",
    "peak": "lr_scale",
}


_FORMER_DEFAULTS = {
    "network": "edge",
    "hidden_weight": 1.0,
    "footprint_weight": FOOTPRINT_WEIGHT,
}
"""What runs did that were begun before these fields existed."""


def is_same_recipe(stored: dict[str, Any], recipe: Recipe) -> bool:
    """Whether a checkpoint's recipe, as ``asdict`` gave it, is this one.

    Runs begun by earlier versions named the fields otherwise, and had fewer.
    """
    named = {_FORMER_NAMES.get(name, name): value for name, value in stored.items()}
    return {**_FORMER_DEFAULTS, **named} == asdict(recipe)


def switched(targets: Targets, recipe: Recipe) -> Targets:
    """The targets without what a recipe leaves out (paper, Table 2), and with its lambda."""
    is_footprint = targets.untraversable > 1
    untraversable = torch.where(is_footprint, recipe.footprint_weight, targets.untraversable)
    is_hidden = (targets.visible_ground == 0) & (targets.visible_ground_valid > 0)
    ground_weight = torch.where(
        is_hidden, targets.ground_weight * recipe.hidden_weight, targets.ground_weight
    )
    unknown = targets.unknown_weight * (recipe.lambda_unknown / LAMBDA)
    if not recipe.footprint_masks:
        unknown = torch.maximum(unknown, recipe.lambda_unknown * (untraversable > 0))
        untraversable = torch.zeros_like(untraversable)
    moving = targets.moving if recipe.moving_objects else torch.zeros_like(targets.moving)
    return replace(
        targets,
        ground_weight=ground_weight,
        untraversable=untraversable,
        unknown_weight=unknown,
        moving=moving,
    )
