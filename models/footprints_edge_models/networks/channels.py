"""The four raw channels that every network outputs, and the maps of a model file.

Raw channels, in order (the published network's own convention, so that its losses apply to both):

0. visible ground, logit (paper: S)
1. ground, seen or hidden, logit (S*)
2. visible depth, sigmoid disparity in (0, 1) (D)
3. ground depth, sigmoid disparity in (0, 1) (D*)

``depth = 1 / (1/max + (1/min - 1/max) * disparity)``, with the range below.
"""

import torch

MIN_DEPTH_M = 0.1
MAX_DEPTH_M = 100.0


def raw_to_maps(raw: torch.Tensor) -> torch.Tensor:
    """Raw channels (B, 4, H, W) to the maps of the file contract: all four in [0, 1]."""
    return torch.cat([torch.sigmoid(raw[:, :2]), raw[:, 2:]], dim=1)


def disparity_to_depth_m(disparity: torch.Tensor) -> torch.Tensor:
    """Sigmoid disparity in [0, 1] to metres, any shape."""
    nearest, farthest = 1 / MIN_DEPTH_M, 1 / MAX_DEPTH_M
    return 1 / (farthest + (nearest - farthest) * disparity)


def depth_to_disparity(depth_m: torch.Tensor) -> torch.Tensor:
    """Metres in [0.1, 100] to sigmoid disparity, any shape."""
    nearest, farthest = 1 / MIN_DEPTH_M, 1 / MAX_DEPTH_M
    return (1 / depth_m - farthest) / (nearest - farthest)
