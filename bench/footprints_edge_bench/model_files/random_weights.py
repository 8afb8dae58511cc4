"""Weights for timing networks that nobody has trained."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from torch import nn


def with_calibrated_random_weights(
    network: "nn.Module", pictures: Sequence[NDArray[np.uint8]]
) -> "nn.Module":
    """Random weights whose activations are about as large as trained ones; batch norms fit them.

    With torch's own first weights they shrink from layer to layer, and what int8 does, and how
    fast, depends on their range.

    Args:
        network: filled in place.
        pictures: uint8 (1, H, W, 3) each, all of one size.

    Returns:
        The network, ready for inference.
    """
    import torch

    with torch.random.fork_rng(devices=[]), torch.no_grad():
        torch.manual_seed(0)
        for module in network.modules():
            if isinstance(module, torch.nn.Conv2d):
                torch.nn.init.kaiming_normal_(module.weight, nonlinearity="relu")
            if isinstance(module, torch.nn.BatchNorm2d):
                module.momentum = 1.0
        images = torch.from_numpy(np.concatenate(pictures)).permute(0, 3, 1, 2)
        network.train()(images.float() / 255)
    return network.eval()
