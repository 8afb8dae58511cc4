"""What a training run does: network, schedule, learning rates, and switches of the loss."""

import math
from dataclasses import asdict, dataclass, replace
from typing import Any

import torch

from footprints_edge_models.data.targets import FOOTPRINT_WEIGHT, LAMBDA, Targets
from footprints_edge_models.networks.efficientnet_lite0 import STAGES
from footprints_edge_models.networks.registry import NETWORKS
from footprints_edge_models.training.losses import BALANCES, LossTerms
from footprints_edge_models.training.schedule import (
    ScheduleStage,
    TrainingError,
    decayed_by_steps,
    decayed_by_time,
    rate_factor,
)


@dataclass(frozen=True)
class Recipe:
    """Everything that decides the result of a run, besides the data.

    Attributes:
        schedule: stages in order; small pictures first cost little and teach most.
        batch: pictures per step and process.
        network: name of the network, a key of ``NETWORKS``.
        coarse_decoder: the network has a second, coarse decoder, see :mod:`networks.edge`.
        encoder_lr: peak learning rate of a pretrained encoder.
        decoder_lr: peak learning rate of everything else.
        weight_decay: weight decay of AdamW.
        warmup_steps: steps of linear warm-up.
        decay: length, as a share of the run, of the decay of the rates to zero at its end; 1 is
            cosine over the whole run.
        minutes: the run ends after so many, decay included, its last stage however long that takes;
            None: after the steps of its schedule.
        decay_from: folder of a run that this one goes on from at its checkpoint, with its optimizer
            and average, without warm-up: with a decay of 1, it finishes that run's weights.
        ema_decay: decay per step of the exponential moving average of weights that is kept.
        seed: seed of weights and data.
        lambda_unknown: the paper's lambda, the weight of unknown pixels (eq. 3c).
        footprint_masks: learn from pixels known to be untraversable (eq. 3b); without, they count
            as unknown.
        moving_objects: leave the ground behind moving objects out of eq. 3a.
        hidden_weight: weight of hidden ground in eq. 3a. Such pixels are few, and the paper weighs
            them as all others: then their gradient drowns beside the easy ones.
        footprint_weight: weight of footprints in eq. 3b.
        balance: of the pixels of eq. 3, a key of ``losses.BALANCES``.
        relative_depth: weight of the relative depth loss beside the paper's.
        dice: weight of the soft Dice loss of both masks beside their cross-entropy.
        frozen_stages: stages of the encoder, from the image on, that do not learn, the stem with
            the first; their gradients are the most expensive.
        init: file of the weights to begin with, a state dict; None begins with the network's
            pretrained encoder, or with random weights where it has none.
        lr_scale: factor on both learning rates; below 1 to fine-tune without forgetting.
        former_focal: the canonical focal length follows the size, as in runs begun by earlier
            versions; not for new ones.
    """

    schedule: tuple[ScheduleStage, ...]
    batch: int = 12
    network: str = "edge"
    coarse_decoder: bool = False
    encoder_lr: float = 3e-4
    decoder_lr: float = 1e-3
    weight_decay: float = 1e-2
    warmup_steps: int = 50
    decay: float = 0.2
    minutes: float | None = None
    decay_from: str | None = None
    ema_decay: float = 0.998
    seed: int = 0
    lambda_unknown: float = LAMBDA
    footprint_masks: bool = True
    moving_objects: bool = True
    hidden_weight: float = 1.0
    footprint_weight: float = FOOTPRINT_WEIGHT
    balance: str = "none"
    relative_depth: float = 0.0
    dice: float = 0.0
    frozen_stages: int = 0
    init: str | None = None
    lr_scale: float = 1.0
    former_focal: bool = False

    def __post_init__(self) -> None:
        """Refuses unknown names and numbers that make no sense.

        Raises:
            TrainingError: if there are any.
        """
        for name, known in (("network", NETWORKS), ("balance", BALANCES)):
            if getattr(self, name) not in known:
                raise TrainingError(f"{name} {getattr(self, name)!r}: there are {', '.join(known)}")
        if not 0 <= self.lambda_unknown <= 1:
            raise TrainingError(
                f"lambda {self.lambda_unknown}: the paper's lambda lies between 0 and 1"
            )
        self._refuse_odd_weights()
        if self.balance == "classes" and self.footprint_weight <= 1:
            raise TrainingError(
                f"footprint weight {self.footprint_weight}: balance by classes tells footprints by "
                "a weight above 1"
            )
        for name, value in (("learning-rate scale", self.lr_scale), ("decay", self.decay)):
            if not 0 < value <= 1:
                raise TrainingError(f"{name} {value}: give a factor above 0, at most 1")
        if self.decay_from is not None and self.init is not None:
            raise TrainingError("initial weights and a run to go on from: give one of them")
        if self.coarse_decoder and self.network != "edge":
            raise TrainingError(f"a coarse decoder: network {self.network} has none")
        stages = len(STAGES) if self.network == "edge" else 0
        if not 0 <= self.frozen_stages <= stages:
            raise TrainingError(
                f"frozen stages {self.frozen_stages}: the encoder of {self.network} has {stages}"
            )

    def _refuse_odd_weights(self) -> None:
        for name in ("hidden_weight", "footprint_weight", "minutes"):
            value = getattr(self, name)
            if value is not None and not 0 < value < math.inf:
                raise TrainingError(f"{name.replace('_', ' ')} {value}: give a positive number")
        for name in ("relative_depth", "dice"):
            value = getattr(self, name)
            if not 0 <= value < math.inf:
                raise TrainingError(f"{name.replace('_', ' ')} {value}: give a number from 0 on")

    @property
    def terms(self) -> LossTerms:
        """What is added to the paper's loss."""
        return LossTerms(self.balance, self.relative_depth, self.dice)

    @property
    def steps(self) -> int:
        """Steps of the schedule."""
        return sum(stage.steps for stage in self.schedule)

    def decayed(self, step: int, time_share: float = 0.0) -> float:
        """How much of the decay lies behind after some steps, and a share of the minutes."""
        if self.minutes is not None:
            return decayed_by_time(time_share, decay=self.decay)
        warmup = self._warmup_steps
        return decayed_by_steps(step, self.steps, warmup=warmup, decay=self.decay)

    def lr_factor(self, step: int, decayed: float) -> float:
        """Learning rate of a step, as a share of the peak."""
        return self.lr_scale * rate_factor(step, decayed, warmup=self._warmup_steps)

    @property
    def _warmup_steps(self) -> int:
        return 0 if self.decay_from is not None else self.warmup_steps


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
    "coarse_decoder": False,
    "hidden_weight": 1.0,
    "footprint_weight": FOOTPRINT_WEIGHT,
    "decay": 1.0,
    "minutes": None,
    "decay_from": None,
    "balance": "none",
    "relative_depth": 0.0,
    "dice": 0.0,
    "frozen_stages": 0,
    "former_focal": True,
}
"""What runs did that were begun before these fields existed."""


def resumed_recipe(stored: dict[str, Any], asked: Recipe) -> Recipe | None:
    """The recipe to go on with, or None where a checkpoint's is another than what is asked.

    Runs begun by earlier versions named the fields otherwise, and had fewer: what they did goes on
    where nothing else is asked.

    Args:
        stored: the checkpoint's recipe, as ``asdict`` gave it.
        asked: as the caller wants it.
    """
    named = {_FORMER_NAMES.get(name, name): value for name, value in stored.items()}
    named = {**_FORMER_DEFAULTS, **named}
    if named["former_focal"]:  # nobody asks for it, and it stays, however often a run is resumed
        decay = named["decay"] if asked.decay == Recipe.decay else asked.decay
        asked = replace(asked, former_focal=True, decay=decay)
    return asked if named == asdict(asked) else None


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
