"""The paper's training loss (section "Final training loss", eq. 3), for any mix of sources.

Each dataset supervises only what it labels. A target without a label has weight zero, so that a
labelled photo, which holds neither depth nor hidden ground, trains visible ground alone.
"""

from collections.abc import Mapping

import torch
import torch.nn.functional as F

from footprints_edge_models.data.targets import Targets
from footprints_edge_models.networks.channels import disparity_to_depth_m


def visible_ground_loss(logit: torch.Tensor, targets: Targets) -> torch.Tensor:
    """Binary cross-entropy of S (paper: l^s), scalar."""
    loss = F.binary_cross_entropy_with_logits(logit, targets.visible_ground, reduction="none")
    return (loss * targets.visible_ground_valid).mean()


def ground_loss(logit: torch.Tensor, targets: Targets) -> torch.Tensor:
    """Eq. 3 over the three pixel sets of S*, scalar."""
    loss = F.binary_cross_entropy_with_logits(logit, targets.ground, reduction="none")
    decided = torch.maximum(targets.ground_weight, targets.untraversable)
    weight = decided * (1 - targets.moving) + (decided == 0) * targets.unknown_weight
    return (loss * weight).mean()


def depth_loss(disparity: torch.Tensor, target_m: torch.Tensor) -> torch.Tensor:
    """log(|d - d^| + 1) where the target is known (paper: l^d and l^d*), mean over all pixels."""
    error_m = (disparity_to_depth_m(disparity) - target_m).abs()
    return (torch.log(error_m + 1) * (target_m > 0)).mean()


def losses(raw: torch.Tensor, targets: Targets) -> dict[str, torch.Tensor]:
    """The four sublosses of one output and their sum, scalars.

    Args:
        raw: float32 (B, 4, H, W), raw channels (see :mod:`channels`).
        targets: of the batch.
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
