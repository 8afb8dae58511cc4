"""The mean of several weights of one network: as good as each where they fit, and steadier.

Weights that began with the same ones and went different ways lie around better ones (Wortsman et
al. 2022, "Model soups").
"""

from collections.abc import Sequence
from pathlib import Path

import torch

from footprints_edge.errors import ModelError
from footprints_edge_models.asset_files.asset import Credit
from footprints_edge_models.networks.checkpoint import (
    load_weights,
    read_checkpoint,
    stated_focal_px,
)
from footprints_edge_models.networks.registry import Network, NetworkSpec
from footprints_edge_models.training.weight_credits import stated_credits


def mean_of(paths: Sequence[Path], spec: NetworkSpec) -> tuple[Network, float | None, list[Credit]]:
    """A network with the mean of weights, the focal length that they state, and all their credits.

    Raises:
        ModelError: a file is damaged, is of another network, or states another focal length.
    """
    checkpoints = [read_checkpoint(path) for path in paths]
    network = spec.build_for(checkpoints[0]).eval()
    total: dict[str, torch.Tensor] = {}
    focal_px = stated_focal_px(checkpoints[0], str(paths[0]))
    for path, weights in zip(paths, checkpoints, strict=True):
        load_weights(network, weights, str(path))
        stated = stated_focal_px(weights, str(path))
        if stated != focal_px:
            raise ModelError(
                f"{path}: its depths are for a focal length of {stated} pixels, those of "
                f"{paths[0]} for {focal_px}; their mean is for none"
            )
        for name, tensor in network.state_dict().items():
            total[name] = total.get(name, 0) + tensor.double() / len(paths)
    own = network.state_dict()
    network.load_state_dict({name: total[name].to(own[name].dtype) for name in own})
    credits = [
        credit
        for path, weights in zip(paths, checkpoints, strict=True)
        for credit in stated_credits(weights, str(path))
    ]
    return network, focal_px, credits
