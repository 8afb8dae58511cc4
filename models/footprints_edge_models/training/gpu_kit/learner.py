"""The network with its optimizer and its average: one step, and the way back after a bad one.

Nothing in a step waits for the GPU: losses stay on the device until somebody reads them.
"""

import copy

import torch
from torch import nn

from footprints_edge_models.networks.registry import Network
from footprints_edge_models.training.beginning import (
    has_bfloat16,
    initial_network,
    keep_statistics,
    parameter_groups,
)
from footprints_edge_models.training.gpu_kit.device_views import DeviceBatch
from footprints_edge_models.training.losses import multiscale_losses
from footprints_edge_models.training.recipe import Recipe, switched


class Learner:
    """A network that learns batch by batch.

    Attributes:
        network: What learns.
        average: Its moving average, the one to use.
        focal_px: Canonical focal length of the weights.
        device: Where both are.
    """

    def __init__(self, recipe: Recipe, device: torch.device) -> None:
        """The network that the recipe begins with, on a device."""
        torch.manual_seed(recipe.seed)
        network, self.focal_px, pretrained = initial_network(recipe)
        self.network: Network = network.to(device)
        self.device = device
        self._recipe = recipe
        self.network.train()
        if pretrained:
            keep_statistics(self.network.encoder)
        self._groups = parameter_groups(self.network, recipe, pretrained=pretrained)
        self._fresh_optimizer()
        self.average = copy.deepcopy(self.network).requires_grad_(False)
        self._steps = 0
        self.lay_out(torch.channels_last)
        self._good = self._states()

    def lay_out(self, layout: torch.memory_format) -> None:
        """The order of the weights and pictures in memory, contiguous or channels last."""
        self._layout = layout
        for network in (self.network, self.average):
            network.to(memory_format=layout)  # type: ignore[call-overload]
        # their memory is another one now
        self._now, self._mean = (_floating(network) for network in (self.network, self.average))

    def gradients(self, batch: DeviceBatch) -> dict[str, torch.Tensor]:
        """The losses of a batch, unread, and their gradients."""
        image, targets = batch
        image = image.contiguous(memory_format=self._layout)
        # bfloat16 keeps float32's range: no loss scaling; the outputs and losses stay float32.
        with torch.autocast(self.device.type, torch.bfloat16, enabled=has_bfloat16(self.device)):
            scales = self.network.scales(image)
        parts = multiscale_losses(scales, switched(targets, self._recipe), self._recipe.terms)
        self._optimizer.zero_grad(set_to_none=True)
        parts["loss"].backward()  # type: ignore[no-untyped-call]
        return {name: part.detach() for name, part in parts.items()}

    def step(self, batch: DeviceBatch, rate: float) -> dict[str, torch.Tensor]:
        """One step at a share of the peak rates; the losses, unread."""
        for group in self._optimizer.param_groups:
            group["lr"] = group["peak"] * rate
        losses = self.gradients(batch)
        nn.utils.clip_grad_norm_(self.network.parameters(), 5.0)
        self._optimizer.step()
        self._update_average()
        return losses

    def restart_average(self) -> None:
        """As the trainer does where the decay begins: what was averaged before is soon old."""
        self._steps = 0

    def keep(self) -> None:
        """Remembers the weights, to come back to."""
        self._good = self._states()

    def go_back(self) -> None:
        """The weights that were kept last, with a fresh optimizer."""
        with torch.no_grad():
            for module, state in zip((self.network, self.average), self._good, strict=True):
                module.load_state_dict(state)
        self._fresh_optimizer()

    def _states(self) -> list[dict[str, torch.Tensor]]:
        return [
            {name: tensor.detach().clone() for name, tensor in module.state_dict().items()}
            for module in (self.network, self.average)
        ]

    def _fresh_optimizer(self) -> None:
        groups = [dict(group) for group in self._groups]
        fused = self.device.type == "cuda"
        self._optimizer = torch.optim.AdamW(groups, fused=fused)

    @torch.no_grad()
    def _update_average(self) -> None:
        """As the trainer's moving average, for all tensors at once and without a wait."""
        weight = 1 - min(self._recipe.ema_decay, (1 + self._steps) / (10 + self._steps))
        self._steps += 1
        torch._foreach_lerp_(self._mean, self._now, weight)


def _floating(network: nn.Module) -> list[torch.Tensor]:
    """Its parameters and buffers, but for counters."""
    tensors = (*network.parameters(), *network.buffers())
    return [tensor.detach() for tensor in tensors if tensor.is_floating_point()]
