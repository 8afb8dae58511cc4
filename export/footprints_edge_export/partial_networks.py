"""Parts of the networks: some of the four maps, or the maps of a coarser head.

Each gives the maps of the file contract, in the contract's order, at the size of the image. The
exported graph has nothing else.
"""

import copy

import torch
import torch.nn.functional as F
from torch import nn

from footprints_edge.model_files.metadata import OUTPUTS
from footprints_edge_models.networks.edge import EdgeNetwork, log_depth_to_disparity
from footprints_edge_models.networks.reference import ReferenceNetwork


class EdgePart(nn.Module):
    """The edge network with heads of fewer channels; its only outputs are at half resolution."""

    SCALES = (1,)

    def __init__(self, network: EdgeNetwork, outputs: str, scale: int) -> None:
        super().__init__()
        assert scale in self.SCALES
        self.outputs, self.scale = outputs, scale
        self.network = copy.deepcopy(network)
        channels = list(OUTPUTS[outputs])
        self.network.head = _some_channels(network.head, channels)
        if network.coarse_head is not None:
            self.network.coarse_head = _some_channels(network.coarse_head, channels)

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        """RGB (B, 3, H, W) in [0, 1] to maps (B, C, H, W)."""
        x = F.interpolate(self.network.half_size(image), scale_factor=2, mode="bilinear")
        masks = sum(channel < 2 for channel in OUTPUTS[self.outputs])
        if masks == 0:
            return log_depth_to_disparity(x)
        if masks == x.shape[1]:
            return torch.sigmoid(x)
        return torch.cat([torch.sigmoid(x[:, :masks]), log_depth_to_disparity(x[:, masks:])], dim=1)


def _some_channels(head: nn.Conv2d, channels: list[int]) -> nn.Conv2d:
    few = nn.Conv2d(head.in_channels, len(channels), 3, padding=1, bias=head.bias is not None)
    few.load_state_dict({key: value[channels] for key, value in head.state_dict().items()})
    return few


class ReferencePart(nn.Module):
    """One of the reference network's trained heads, with only the decoders it needs."""

    SCALES = (1, 2, 4)

    def __init__(self, network: ReferenceNetwork, outputs: str, scale: int) -> None:
        super().__init__()
        assert scale in self.SCALES
        self.outputs, self.scale = outputs, scale
        self.network = network

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        """RGB (B, 3, H, W) in [0, 1] to maps (B, C, H, W)."""
        features = self.network.encoder(image)
        head = f"1/{self.scale}"
        maps = []
        if self.outputs != "depths":
            maps.append(torch.sigmoid(self._full(self.network.mask_decoder(features)[head])))
        if self.outputs != "masks":
            # As in training, the sigmoid of a disparity comes before the resize.
            maps.append(self._full(torch.sigmoid(self.network.depth_decoder(features)[head])))
        return torch.cat(maps, dim=1)

    def _full(self, x: torch.Tensor) -> torch.Tensor:
        if self.scale == 1:
            return x
        return F.interpolate(x, scale_factor=self.scale, mode="bilinear")
