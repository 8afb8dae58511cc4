"""Training in several processes, each on its share of every batch, as ``torchrun`` starts them."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import torch
from torch import distributed, nn
from torch.distributed.nn.functional import all_reduce
from torch.nn.parallel import DistributedDataParallel

from footprints_edge_models.networks.registry import Network


@dataclass(frozen=True)
class ProcessGroup:
    """This process among those that train together; one alone is rank 0 of 1."""

    rank: int = 0
    size: int = 1

    @property
    def is_first(self) -> bool:
        """Whether this one writes the files."""
        return self.rank == 0

    def agreed(self, value: float) -> float:
        """The first process's value, in all of them."""
        if self.size == 1:
            return value
        values = [value]
        distributed.broadcast_object_list(values, src=0)
        return values[0]

    def mean(self, values: torch.Tensor) -> torch.Tensor:
        """The mean over all processes."""
        if self.size > 1:
            distributed.all_reduce(values)
        return values / self.size


@contextmanager
def process_group(device: torch.device) -> Iterator[ProcessGroup]:
    """Joins the group that ``torchrun``'s environment describes, over NCCL or, on CPUs, gloo."""
    size = int(os.environ.get("WORLD_SIZE", "1"))
    if size == 1:
        yield ProcessGroup()
        return
    if device.type == "cuda":
        torch.cuda.set_device(device)  # else all of them would exchange by the first GPU
    distributed.init_process_group("gloo" if device.type == "cpu" else "nccl")
    try:
        yield ProcessGroup(distributed.get_rank(), size)
    finally:
        distributed.destroy_process_group()


class Scales(nn.Module):
    """A network whose ``forward`` gives all its outputs."""

    def __init__(self, network: Network) -> None:
        super().__init__()
        self.network = network

    def forward(self, image: torch.Tensor) -> dict[str, torch.Tensor]:
        """See the network's ``scales``."""
        return self.network.scales(image)


def in_parallel(network: Network, group: ProcessGroup) -> nn.Module:
    """What to call for a network's outputs, its gradients the means over the group's processes."""
    if group.size == 1:
        return Scales(network)
    _sync_batch_norms(network)
    # the paper's network has batch norms that it never applies
    idle = any(name.endswith("bn1.weight") for name, _ in network.named_parameters())
    return DistributedDataParallel(
        Scales(network), broadcast_buffers=False, find_unused_parameters=idle
    )


class SyncedBatchNorm2d(nn.BatchNorm2d):
    """Batch norm over the batches of all processes; torch's own wants CUDA."""

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """(B, C, H, W) to the same; every process with as many pixels."""
        if not self.training or self.running_mean is None or self.running_var is None:
            return super().forward(x)
        size = distributed.get_world_size()
        mean = _sum(x.float().mean(dim=(0, 2, 3))) / size
        centred = x - mean[:, None, None]
        variance = _sum(centred.float().square().mean(dim=(0, 2, 3))) / size
        count = size * x.numel() / x.shape[1]
        with torch.no_grad():
            if self.num_batches_tracked is not None:
                self.num_batches_tracked.add_(1)
            momentum = 0.1 if self.momentum is None else self.momentum
            self.running_mean.lerp_(mean, momentum)
            self.running_var.lerp_(variance * count / (count - 1), momentum)
        scale: torch.Tensor = self.weight * torch.rsqrt(variance + self.eps)
        shifted: torch.Tensor = centred * scale[:, None, None] + self.bias[:, None, None]
        return shifted


def _sum(x: torch.Tensor) -> torch.Tensor:
    """Over all processes; gradients pass."""
    return all_reduce(x)  # type: ignore[no-any-return, no-untyped-call]


def _sync_batch_norms(network: nn.Module) -> None:
    """Lets the batch norms see all processes' pictures; keeps weights and state dict."""
    for module in network.modules():
        if type(module) is nn.BatchNorm2d:
            module.__class__ = SyncedBatchNorm2d
