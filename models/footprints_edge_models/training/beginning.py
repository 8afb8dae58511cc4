"""The network that a run begins with, what of it learns at which rate, and its moving average."""

from pathlib import Path
from typing import Any

import torch
from torch import nn

from footprints_edge_models.networks.checkpoint import (
    load_weights,
    read_checkpoint,
    stated_focal_px,
)
from footprints_edge_models.networks.edge import FOCAL_PX, EdgeNetwork, has_coarse_decoder
from footprints_edge_models.networks.registry import NETWORKS, Network
from footprints_edge_models.training.recipe import Recipe
from footprints_edge_models.training.schedule import TrainingError


def initial_network(recipe: Recipe) -> tuple[Network, float, bool]:
    """The network, its canonical focal length, and whether its encoder is trained already.

    Frozen stages do not learn; what the weights lack of a coarse decoder begins without a say.
    """
    spec = NETWORKS[recipe.network]
    parts = {"coarse_decoder": True} if recipe.coarse_decoder else {}
    pretrained = None if recipe.init is not None else spec.pretrained
    network = (pretrained or spec.build)(**parts)
    focal_px = None
    if recipe.init is not None:
        weights = read_checkpoint(Path(recipe.init))
        focal_px = stated_focal_px(weights, recipe.init)
        has_one = has_coarse_decoder(weights)
        if has_one and not recipe.coarse_decoder:
            raise TrainingError(f"{recipe.init}: has a coarse decoder: train with --coarse-decoder")
        if recipe.coarse_decoder and not has_one and isinstance(weights, dict):
            fresh = {k: v for k, v in network.state_dict().items() if k.startswith("coarse_")}
            weights = {**fresh, **weights}  # it begins without a say
        load_weights(network, weights, recipe.init)
    if recipe.frozen_stages and isinstance(network, EdgeNetwork):
        network.encoder.freeze(recipe.frozen_stages)
    return network, focal_px or FOCAL_PX, bool(pretrained or recipe.init)


def keep_statistics(encoder: nn.Module) -> None:
    """Batch norms keep their statistics: those of a mix of sources are no better.

    What int8 folds into the weights is then what was trained, and a step on a CPU is much faster.
    """
    for module in encoder.modules():
        if isinstance(module, nn.BatchNorm2d):
            module.eval()


def parameter_groups(
    network: nn.Module, recipe: Recipe, *, pretrained: bool
) -> list[dict[str, Any]]:
    """Groups of AdamW: encoder and the rest, matrices and what is not decayed, with peak rates."""
    groups = []
    encoder_lr = recipe.encoder_lr if pretrained else recipe.decoder_lr
    for is_encoder, peak in ((True, encoder_lr), (False, recipe.decoder_lr)):
        for is_matrix in (True, False):  # norms and biases are not decayed
            parameters = [
                p
                for name, p in network.named_parameters()
                if name.startswith("encoder.") == is_encoder
                and (p.ndim > 1) == is_matrix
                and p.requires_grad
            ]
            decay = recipe.weight_decay if is_matrix else 0.0
            groups.append({"params": parameters, "peak": peak, "lr": 0.0, "weight_decay": decay})
    return groups


def moving_average(
    decay: float,
    averages: list[torch.Tensor],
    currents: list[torch.Tensor],
    count: torch.Tensor | int,
) -> None:
    """Exponential, but plain at first, so that the fresh weights are soon forgotten; in place."""
    step = int(count)
    weight = 1 - min(decay, (1 + step) / (10 + step))
    if averages[0].is_floating_point():  # torch calls this with tensors of one type
        torch._foreach_lerp_(averages, currents, weight)
    else:
        torch._foreach_copy_(averages, currents)


def has_bfloat16(device: torch.device) -> bool:
    """Whether bfloat16 is faster than float32: without it, a CPU emulates it, which is slow."""
    return device.type != "cpu" or bool(torch.ops.mkldnn._is_mkldnn_bf16_supported())
