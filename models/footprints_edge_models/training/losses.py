"""The paper's training loss (section "Final training loss", eq. 3), for any mix of sources.

Each source supervises only what it knows. Where a target is unknown its weight is zero, so that a
labelled photo, which says nothing about distance or about what is hidden, trains what it can.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields

import torch
import torch.nn.functional as F

from footprints_edge_models.networks.channels import disparity_to_depth_m

LAMBDA = 0.25
"""The prior of eq. 3c: how strongly unknown pixels are held to be untraversable."""
FOOTPRINT_WEIGHT = 3.0
"""Of eq. 3b where a thing's footprint is known: few pixels, and the ones that a path must avoid."""


@dataclass(frozen=True)
class Targets:
    """What is known of a batch; every tensor is float32 (B, H, W).

    The three pixel sets of the paper are ``ground`` (traversable), ``untraversable`` and all else.

    Attributes:
        visible_ground: 1 where the surface seen is walkable, 0 where not.
        visible_ground_known: 1 where ``visible_ground`` is a label, 0 where it is void.
        ground: 1 on pixels known to be traversable, seen or hidden.
        untraversable: weight of eq. 3b on pixels known not to be, 0 on others.
        prior: weight of eq. 3c on the remaining pixels: the paper's lambda where a video was
            watched and saw no ground there, 0 where nothing is known.
        moving: 1 on moving objects (the paper's 1 - mu), whose hidden ground is not learned.
        visible_depth_m: metres, 0 where unknown.
        ground_depth_m: metres, 0 where unknown or not ground.
    """

    visible_ground: torch.Tensor
    visible_ground_known: torch.Tensor
    ground: torch.Tensor
    untraversable: torch.Tensor
    prior: torch.Tensor
    moving: torch.Tensor
    visible_depth_m: torch.Tensor
    ground_depth_m: torch.Tensor

    def to(self, device: torch.device) -> "Targets":
        """The same on another device."""
        return Targets(
            **{
                field.name: getattr(self, field.name).to(device, non_blocking=True)
                for field in fields(self)
            }
        )


def visible_ground_loss(logit: torch.Tensor, targets: Targets) -> torch.Tensor:
    """Binary cross-entropy of S (paper: l^s), scalar."""
    loss = F.binary_cross_entropy_with_logits(logit, targets.visible_ground, reduction="none")
    return (loss * targets.visible_ground_known).mean()


def ground_loss(logit: torch.Tensor, targets: Targets) -> torch.Tensor:
    """Eq. 3 over the three pixel sets of S*, scalar."""
    loss = F.binary_cross_entropy_with_logits(logit, targets.ground, reduction="none")
    decided = torch.maximum(targets.ground, targets.untraversable)
    weight = decided * (1 - targets.moving) + (decided == 0) * targets.prior
    return (loss * weight).mean()


def depth_loss(disparity: torch.Tensor, target_m: torch.Tensor) -> torch.Tensor:
    """log(|d - d^| + 1) where the target is known (paper: l^d and l^d*), mean over all pixels."""
    error_m = (disparity_to_depth_m(disparity) - target_m).abs()
    return (torch.log(error_m + 1) * (target_m > 0)).mean()


def losses(raw: torch.Tensor, targets: Targets) -> dict[str, torch.Tensor]:
    """The four sublosses of one output and their sum, scalars.

    Args:
        raw: float32 (B, 4, H, W), raw channels (see :mod:`maps`).
        targets: what is known of the batch.
    """
    parts = {
        "visible_ground": visible_ground_loss(raw[:, 0], targets),
        "ground": ground_loss(raw[:, 1], targets),
        "visible_depth": depth_loss(raw[:, 2], targets.visible_depth_m),
        "ground_depth": depth_loss(raw[:, 3], targets.ground_depth_m),
    }
    return parts | {"loss": torch.stack(list(parts.values())).sum()}


def multiscale_losses(
    scales: Mapping[str, torch.Tensor], targets: Targets
) -> dict[str, torch.Tensor]:
    """Means of `losses` over a network's outputs, each (B, 4, H, W) at full size."""
    found = [losses(raw, targets) for raw in scales.values()]
    return {name: torch.stack([parts[name] for parts in found]).mean() for name in found[0]}
