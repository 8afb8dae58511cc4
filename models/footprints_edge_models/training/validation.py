"""Scores of a network on held-out samples, per dataset, as training logs them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from footprints_edge_models.data.augmentation import render_view
from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.networks.channels import disparity_to_depth_m
from footprints_edge_models.networks.edge import FOCAL_PX
from footprints_edge_models.sample import Sample
from footprints_edge_models.training.batches import stack


@dataclass(frozen=True)
class ValidationScores:
    """Scores over all labelled pixels; NaN where there are none.

    Attributes:
        visible_ground_iou: IoU of S at probability 0.5.
        ground_iou: IoU of S*, over traversable and untraversable pixels.
        visible_depth_abs_rel: mean |d - d^| / d of D, canonical camera.
        ground_depth_abs_rel: the same of D*.
        ground_depth_a1: share of D* within a factor of 1.25.
        hidden_auc: how often S* is higher on hidden ground than on a footprint; 0.5 is chance: the
            network does not know where things stand.
    """

    visible_ground_iou: float
    ground_iou: float
    visible_depth_abs_rel: float
    ground_depth_abs_rel: float
    ground_depth_a1: float
    hidden_auc: float


@torch.no_grad()
def validate(
    network: nn.Module,
    samples: Sequence[Sample],
    size: tuple[int, int],
    focal_px: float = FOCAL_PX,
) -> ValidationScores:
    """ValidationScores on the central views of samples, one at a time.

    Args:
        network: to validate.
        samples: with labels.
        size: (H, W) of the views.
        focal_px: canonical focal length of the network's depths.
    """
    device = next(network.parameters()).device
    pixels = np.zeros(9)
    hidden_logits, footprint_logits = [], []
    for sample in samples:
        image, targets = stack([render_view(sample, size, focal_px=focal_px)])
        targets = targets.to(device)
        raw = network(image.to(device).float() / 255)
        visible, ground = raw[:, 0] > 0, raw[:, 1] > 0
        visible_m, ground_m = disparity_to_depth_m(raw[:, 2:]).unbind(1)
        valid = targets.visible_ground_valid > 0
        decided = (targets.ground + targets.untraversable) > 0
        true_visible, true_ground = targets.visible_ground > 0, targets.ground > 0
        has_visible_m, has_ground_m = targets.visible_depth_m > 0, targets.ground_depth_m > 0
        visible_error = (visible_m / targets.visible_depth_m - 1).abs()[has_visible_m]
        hidden = true_ground & ~true_visible & valid
        hidden_logits.append(raw[:, 1][hidden].float().cpu().numpy())
        footprint_logits.append(raw[:, 1][targets.untraversable > 1].float().cpu().numpy())
        ratio = (ground_m / targets.ground_depth_m)[has_ground_m]
        pixels += np.array(
            [
                (visible & true_visible & valid).sum().item(),
                ((visible | true_visible) & valid).sum().item(),
                (ground & true_ground & decided).sum().item(),
                ((ground | true_ground) & decided).sum().item(),
                visible_error.sum().item(),
                has_visible_m.sum().item(),
                (ratio - 1).abs().sum().item(),
                (torch.maximum(ratio, 1 / ratio) < 1.25).sum().item(),
                has_ground_m.sum().item(),
            ]
        )
    with np.errstate(invalid="ignore"):
        values = pixels[[0, 2, 4, 6, 7]] / pixels[[1, 3, 5, 8, 8]]
    auc = rank_auc(np.concatenate(hidden_logits), np.concatenate(footprint_logits))
    return ValidationScores(*map(float, (*values, auc)))


def rank_auc(high: NDArray[np.float32], low: NDArray[np.float32]) -> float:
    """Share of pairs (one of `high`, one of `low`) that are in order; NaN if one is empty.

    The area under the ROC curve, by ranks (Mann and Whitney, 1947).
    """
    if not len(high) or not len(low):
        return math.nan
    low = np.sort(low)
    below = np.searchsorted(low, high, "left") + np.searchsorted(low, high, "right")
    return float(below.mean() / 2 / len(low))


def validate_all(
    network: nn.Module,
    datasets: dict[str, TrainingDataset],
    size: tuple[int, int],
    focal_px: float = FOCAL_PX,
    most: int = 40,
) -> dict[str, ValidationScores]:
    """Scores of each dataset's held-out samples, at most ``most`` of each, evenly spread."""
    was_training = network.training
    network.eval()
    scores = {
        name: validate(network, spread(dataset.held_out, most), size, focal_px)
        for name, dataset in datasets.items()
        if dataset.held_out
    }
    network.train(was_training)
    return scores


def spread(samples: Sequence[Sample], most: int = 40) -> Sequence[Sample]:
    """At most so many of them, evenly spread."""
    return samples[:: max(1, -(-len(samples) // most))]
