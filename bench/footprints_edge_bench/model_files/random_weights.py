"""Calibrated random weights, for timing networks that nobody has trained."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from torch import nn


def with_calibrated_random_weights(
    network: "nn.Module", images: Sequence[NDArray[np.uint8]]
) -> "nn.Module":
    """Random weights with activation ranges like those of trained ones; calibrates batch norms.

    With torch's default initialisation, activations shrink from layer to layer. The speed and the
    error of int8 depend on their range.

    Args:
        network: the network; its weights are set in place.
        images: uint8 (1, H, W, 3) each, all of one size.

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
        batch = torch.from_numpy(np.concatenate(images)).permute(0, 3, 1, 2)
        network.train()(batch.float() / 255)
    return network.eval()
