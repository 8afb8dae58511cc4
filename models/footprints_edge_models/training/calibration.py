"""Calibration of both masks on held-out photos: a temperature and a bias each.

Weighted losses teach probabilities that are not shares; Platt's fit of a logistic curve to the
logits (1999) makes 0.5 the right threshold again. It goes into the last convolution, so that the
network stays what it was. It is fitted on one half of the photos and scored on the other.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import nn

from footprints_edge_models.data.augmentation import render_view
from footprints_edge_models.networks.edge import EdgeNetwork
from footprints_edge_models.networks.registry import Network
from footprints_edge_models.sample import Sample
from footprints_edge_models.training.batches import stack
from footprints_edge_models.training.schedule import TrainingError

PIXELS_OF_A_PHOTO = 4000
"""As many labelled pixels of each mask are taken of a photo, evenly spread."""


@dataclass(frozen=True)
class Calibration:
    """What makes a mask's logits right: ``scale * logit + bias``.

    Attributes:
        scale: the inverse of the temperature.
        bias: added.
        before: mean cross-entropy before, nats a pixel, on photos that it was not fitted on.
        after: and with both.
    """

    scale: float
    bias: float
    before: float
    after: float


@dataclass(frozen=True)
class MaskPixels:
    """Labelled pixels of a mask.

    Attributes:
        logits: (N,).
        is_true: (N,), the labels.
    """

    logits: NDArray[np.float32] = field(repr=False)
    is_true: NDArray[np.bool_] = field(repr=False)


def fit(pixels: MaskPixels, others: MaskPixels) -> Calibration:
    """The logistic curve of greatest likelihood on ``pixels``, scored on ``others``.

    Raises:
        TrainingError: not both labels are there, or the logits do not tell them apart at all.
    """
    for each in (pixels, others):
        if not each.is_true.any() or each.is_true.all():
            raise TrainingError("calibration needs held-out pixels on and off each mask")
    line = torch.tensor([1.0, 0.0], dtype=torch.float64, requires_grad=True)
    optimizer = torch.optim.LBFGS([line], max_iter=100, line_search_fn="strong_wolfe")

    def loss(of: MaskPixels) -> torch.Tensor:
        logits = torch.from_numpy(of.logits).double()
        true = torch.from_numpy(of.is_true).double()
        return F.binary_cross_entropy_with_logits(line[0] * logits + line[1], true)

    def closure() -> torch.Tensor:
        optimizer.zero_grad()
        value = loss(pixels)
        value.backward()  # type: ignore[no-untyped-call]
        return value

    before = loss(others).item()
    optimizer.step(closure)  # type: ignore[no-untyped-call]
    scale, bias = line.tolist()
    if not scale > 0:
        raise TrainingError(f"the mask is lower where its label is 1 (scale {scale:.3g})")
    return Calibration(scale, bias, before, loss(others).item())


@torch.no_grad()
def calibrate(
    network: Network, samples: Sequence[Sample], others: Sequence[Sample], size: tuple[int, int]
) -> tuple[Calibration, Calibration]:
    """Fit both masks, S and S*, on photos, and put what is found into the network.

    Args:
        network: in evaluation mode; its last convolution is changed.
        samples: photos that it was not trained on, to fit on.
        others: and others, of other places, to score the fit on.
        size: (H, W) of their views.

    Raises:
        TrainingError: the photos' labels do not suffice.
    """
    if not samples or not others:
        raise TrainingError(
            f"calibration needs held-out photos to fit on, and others to score it on; there are "
            f"{len(samples)} and {len(others)}"
        )
    fitted, scored = (_pixels(network, each, size) for each in (samples, others))
    with torch.enable_grad():
        seen, ground = (fit(*both) for both in zip(fitted, scored, strict=True))
    for layer in _last_convolutions(network):
        for channel, calibration in enumerate((seen, ground)):
            layer.weight[channel].mul_(calibration.scale)
            if layer.bias is not None:
                layer.bias[channel].mul_(calibration.scale).add_(calibration.bias)
    return seen, ground


def _pixels(
    network: Network, samples: Sequence[Sample], size: tuple[int, int]
) -> tuple[MaskPixels, MaskPixels]:
    """Labelled pixels of S and S*, as many of each photo."""
    logits: tuple[list[NDArray[np.float32]], ...] = ([], [])
    labels: tuple[list[NDArray[np.bool_]], ...] = ([], [])
    device = next(network.parameters()).device
    for sample in samples:
        image, targets = stack([render_view(sample, size)])
        raw = network(image.to(device).float() / 255).cpu()
        known = (
            targets.visible_ground_valid > 0,
            ((targets.ground_weight > 0) | (targets.untraversable > 0)) & (targets.moving == 0),
        )
        for mask, true in enumerate((targets.visible_ground, targets.ground)):
            found, is_true = raw[:, mask][known[mask]], true[known[mask]] > 0
            every = max(1, len(found) // PIXELS_OF_A_PHOTO)
            logits[mask].append(found[::every].numpy())
            labels[mask].append(is_true[::every].numpy())
    seen, ground = (
        MaskPixels(np.concatenate(x), np.concatenate(y))
        for x, y in zip(logits, labels, strict=True)
    )
    return seen, ground


def _last_convolutions(network: Network) -> list[nn.Conv2d]:
    """The layers whose first two channels are the logits of the masks."""
    if isinstance(network, EdgeNetwork):
        return network.heads
    decoder = network.mask_decoder
    heads = (decoder.outconv1, decoder.outconv2, decoder.outconv3, decoder.outconv4[1])
    return [layer for head in heads for layer in head.modules() if isinstance(layer, nn.Conv2d)]
