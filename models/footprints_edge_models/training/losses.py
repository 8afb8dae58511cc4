"""The paper's training loss (section "Final training loss", eq. 3), for any mix of sources.

Each dataset supervises only what it labels. A target without a label has weight zero, so that a
labelled photo, which holds neither depth nor hidden ground, trains visible ground alone. Beside the
paper's terms there are others to compare with, which weigh nothing unless asked for.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import torch
import torch.nn.functional as F

from footprints_edge_models.data.targets import Targets
from footprints_edge_models.networks.channels import disparity_to_depth_m

BALANCES = {
    "none": "as eq. 3 weighs them",
    "classes": "hidden ground and footprints each count as much as visible ground, in every batch",
    "focal": "a pixel counts the less the surer it is already right",
}
"""How pixels of S* are weighed against each other."""
FOCUS = 2.0
"""The exponent of the focal loss (Lin et al., ICCV 2017, eq. 4)."""
MOST_BALANCE = 20.0
"""A class that a batch hardly shows weighs no more than this."""


@dataclass(frozen=True)
class LossTerms:
    """What is added to the paper's loss.

    Attributes:
        balance: a key of ``BALANCES``.
        relative_depth: weight of the relative depth loss.
        dice: weight of the soft Dice loss.
    """

    balance: str = "none"
    relative_depth: float = 0.0
    dice: float = 0.0


PAPER = LossTerms()
"""The paper's loss alone."""


def visible_ground_loss(logit: torch.Tensor, targets: Targets) -> torch.Tensor:
    """Binary cross-entropy of S (paper: l^s), scalar."""
    loss = F.binary_cross_entropy_with_logits(logit, targets.visible_ground, reduction="none")
    return (loss * targets.visible_ground_valid).mean()


def ground_loss(
    logit: torch.Tensor, targets: Targets, weight: torch.Tensor | None = None
) -> torch.Tensor:
    """Eq. 3 over the three pixel sets of S*, scalar.

    Args:
        logit: of S*, (B, H, W).
        targets: of the batch.
        weight: further factor on each pixel, (B, H, W).
    """
    loss = F.binary_cross_entropy_with_logits(logit, targets.ground, reduction="none")
    weights = ground_weights(targets)
    return (loss * (weights if weight is None else weights * weight)).mean()


def ground_weights(targets: Targets) -> torch.Tensor:
    """The weight of each pixel in eq. 3, (B, H, W)."""
    decided = torch.maximum(targets.ground_weight, targets.untraversable)
    return decided * (1 - targets.moving) + (decided == 0) * targets.unknown_weight


def class_balance(targets: Targets) -> torch.Tensor:
    """Factors that give hidden ground and footprints the total weight of visible ground.

    One factor a class and batch, at least 1 and at most ``MOST_BALANCE``; float32 (B, H, W).
    """
    weights = ground_weights(targets)
    is_ground = targets.ground > 0
    is_labelled = targets.visible_ground_valid > 0
    seen = is_ground & is_labelled & (targets.visible_ground > 0)
    hidden = is_ground & is_labelled & (targets.visible_ground == 0)
    factors = torch.ones_like(weights)
    wanted = (weights * seen).sum()
    for few in (hidden, targets.untraversable > 1):
        factor = (wanted / (weights * few).sum().clamp_min(1e-6)).clamp(1.0, MOST_BALANCE)
        factors = torch.where(few, factor, factors)
    return factors


def focal_factor(logit: torch.Tensor, targets: Targets) -> torch.Tensor:
    """(1 - p of what is true) ** ``FOCUS``, of the same mean as 1 over p evenly spread."""
    probability = torch.sigmoid(logit)
    wrong = torch.where(targets.ground > 0, 1 - probability, probability)
    return (FOCUS + 1) * wrong**FOCUS


def dice_loss(logit: torch.Tensor, true: torch.Tensor, weight: torch.Tensor) -> torch.Tensor:
    """Soft Dice loss of a mask (Milletari et al., 3DV 2016), mean over its pictures, scalar.

    Args:
        logit: (B, H, W).
        true: (B, H, W), 1 on the mask.
        weight: (B, H, W), 0 where there is no label. A picture without any adds nothing.
    """
    known = (weight > 0).float()
    probability = torch.sigmoid(logit) * known
    true = true * known
    both = (probability * true).sum(dim=(1, 2))
    total = probability.sum(dim=(1, 2)) + true.sum(dim=(1, 2))
    return ((1 - (2 * both + 1) / (total + 1)) * known.amax(dim=(1, 2))).mean()


def depth_loss(disparity: torch.Tensor, target_m: torch.Tensor) -> torch.Tensor:
    """log(|d - d^| + 1) where the target is known (paper: l^d and l^d*), mean over all pixels."""
    error_m = (disparity_to_depth_m(disparity) - target_m).abs()
    return (torch.log(error_m + 1) * (target_m > 0)).mean()


def relative_depth_loss(disparity: torch.Tensor, target_m: torch.Tensor) -> torch.Tensor:
    """|log d - log d^| where the target is known, and |its mean| of each picture, scalar.

    The first, a mean over all pixels, counts a tenth too far alike near by and far away. The
    second, a mean over pictures, is what a whole picture is too far.
    """
    known = target_m > 0
    target = torch.where(known, target_m, 1.0)
    error = (torch.log(disparity_to_depth_m(disparity)) - torch.log(target)) * known
    count = known.sum(dim=(1, 2)).clamp_min(1)
    return error.abs().mean() + (error.sum(dim=(1, 2)) / count).abs().mean()


def losses(
    raw: torch.Tensor, targets: Targets, terms: LossTerms = PAPER
) -> dict[str, torch.Tensor]:
    """The sublosses of one output and their sum, scalars.

    Args:
        raw: float32 (B, 4, H, W), raw channels (see :mod:`channels`).
        targets: of the batch.
        terms: what is added to the paper's loss.
    """
    weight = None
    if terms.balance == "classes":
        weight = class_balance(targets)
    elif terms.balance == "focal":
        weight = focal_factor(raw[:, 1], targets)
    parts = {
        "visible_ground": visible_ground_loss(raw[:, 0], targets),
        "ground": ground_loss(raw[:, 1], targets, weight),
        "visible_depth": depth_loss(raw[:, 2], targets.visible_depth_m),
        "ground_depth": depth_loss(raw[:, 3], targets.ground_depth_m),
    }
    if terms.relative_depth:
        both = zip(raw[:, 2:].unbind(1), _depths_m(targets), strict=True)
        found = [relative_depth_loss(disparity, target_m) for disparity, target_m in both]
        parts["relative_depth"] = terms.relative_depth * torch.stack(found).sum()
    if terms.dice:
        seen = dice_loss(raw[:, 0], targets.visible_ground, targets.visible_ground_valid)
        decided = torch.maximum(targets.ground_weight, targets.untraversable)
        ground = dice_loss(raw[:, 1], targets.ground, decided * (1 - targets.moving))
        parts["dice"] = terms.dice * (seen + ground)
    return parts | {"loss": torch.stack(list(parts.values())).sum()}


def _depths_m(targets: Targets) -> tuple[torch.Tensor, torch.Tensor]:
    return targets.visible_depth_m, targets.ground_depth_m


def multiscale_losses(
    scales: Mapping[str, torch.Tensor], targets: Targets, terms: LossTerms = PAPER
) -> dict[str, torch.Tensor]:
    """Means of `losses` over a network's outputs, each (B, 4, H, W) at full size."""
    found = [losses(raw, targets, terms) for raw in scales.values()]
    return {name: torch.stack([parts[name] for parts in found]).mean() for name in found[0]}
