"""The edge network, made for int8 on small CPUs.

EfficientNet-Lite0 and a four-stage skip decoder with nothing in it that an int8 runtime cannot
fuse: zero padding, ReLU, nearest upsampling, concatenation, 3x3 convolutions. Its four outputs are
predicted at half resolution and resized bilinearly.

It may have a second decoder, as the paper has one for what is hidden. Hidden ground is smooth and
needs context more than pixels, so this one is coarse: it leaves the first at 1/16, ends at 1/4, and
its outputs are added to those of the first, which then have the borders left to say.

Depth is predicted as the logarithm of metres: equal steps of the output are equal ratios of
distance, so that neither a float16 nor a coarse activation before the last layer costs more far
away than near by. It leaves the network as the paper's sigmoid disparity.
"""

import math
from collections.abc import Mapping, Sequence

import torch
import torch.nn.functional as F
from torch import nn

from footprints_edge.inputs.preprocessing import BUDGET_PX
from footprints_edge_models.networks.channels import MAX_DEPTH_M, MIN_DEPTH_M, depth_to_disparity
from footprints_edge_models.networks.efficientnet_lite0 import (
    FEATURE_CHANNELS,
    Lite0Encoder,
    imagenet_classifier,
)

DECODER_CHANNELS = (128, 64, 48, 32)
"""Of the stages at 1/16, 1/8, 1/4 and 1/2; the first is of both decoders."""
COARSE_DECODER_CHANNELS = (64, 48)
"""Of the coarse decoder's own stages, at 1/8 and 1/4."""
FOCAL_PX = 400.0
"""Focal length of the canonical camera its depths are for, in pixels of the input of any size.

A convolution sees pixels: an object of so many pixels is equally far away in an image of any size.
"""


def former_focal_px(size: tuple[int, int]) -> float:
    """The canonical focal length at a base size (H, W) in runs begun by earlier versions.

    They took a small image for one of the same camera with fewer pixels.
    """
    return FOCAL_PX * math.sqrt(size[0] * size[1] / BUDGET_PX)


class UpStage(nn.Module):
    """Nearest x2, concatenation with the encoder's feature, 3x3 convolution, batch norm, ReLU."""

    def __init__(self, inputs: int, skip: int, outputs: int) -> None:
        super().__init__()
        self.conv = nn.Sequential(
            nn.Conv2d(inputs + skip, outputs, 3, padding=1, bias=False),
            nn.BatchNorm2d(outputs),
            nn.ReLU(),
        )

    def forward(self, x: torch.Tensor, skip: torch.Tensor) -> torch.Tensor:
        """(B, inputs, H, W) and (B, skip, 2H, 2W) to (B, outputs, 2H, 2W)."""
        if self.training:
            return self._forward_training(x, skip)
        x = F.interpolate(x, scale_factor=2, mode="nearest")
        return self.conv(torch.cat([x, skip], dim=1))  # type: ignore[no-any-return]

    def _forward_training(self, x: torch.Tensor, skip: torch.Tensor) -> torch.Tensor:
        """The same by a transposed convolution: neither a large copy nor four equal pixels."""
        conv = self.conv[0]
        assert isinstance(conv, nn.Conv2d)
        of_x, of_skip = conv.weight[:, : x.shape[1]], conv.weight[:, x.shape[1] :]
        x = F.conv_transpose2d(x, upsampling_filters(of_x), stride=2, padding=1)
        x = x + F.conv2d(skip, of_skip, padding=1)
        return self.conv[1:](x)  # type: ignore[no-any-return]


def upsampling_filters(filters: torch.Tensor) -> torch.Tensor:
    """Filters (inputs, outputs, 4, 4) of a transposed convolution of stride 2 and padding 1.

    It does what nearest x2 and a convolution of ``filters`` (outputs, inputs, 3, 3), padding 1, do.
    """
    x = filters.flip(2, 3).transpose(0, 1)
    x = F.pad(x, (0, 1)) + F.pad(x, (1, 0))
    return F.pad(x, (0, 0, 0, 1)) + F.pad(x, (0, 0, 1, 0))


class EdgeNetwork(nn.Module):
    """RGB (B, 3, H, W) in [0, 1], sides multiples of 32, to raw channels (see :mod:`channels`).

    Args:
        coarse_decoder: whether there is a second, coarse decoder. It begins without a say.
    """

    def __init__(self, *, coarse_decoder: bool = False) -> None:
        super().__init__()
        self.encoder = Lite0Encoder()
        deepest, *skips = FEATURE_CHANNELS[::-1]
        self.stages = _stages(deepest, skips, DECODER_CHANNELS)
        context = DECODER_CHANNELS[0]
        self.coarse_stages = (
            _stages(context, skips[1:], COARSE_DECODER_CHANNELS) if coarse_decoder else None
        )
        self.head = nn.Conv2d(DECODER_CHANNELS[-1], 4, 3, padding=1)
        self.coarse_head: nn.Conv2d | None = None
        if coarse_decoder:
            self.coarse_head = nn.Conv2d(COARSE_DECODER_CHANNELS[-1], 4, 3, padding=1, bias=False)
            nn.init.zeros_(self.coarse_head.weight)

    @property
    def heads(self) -> list[nn.Conv2d]:
        """The last convolutions, whose channels are those of the output."""
        return [head for head in (self.head, self.coarse_head) if head is not None]

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        """Raw channels (B, 4, H, W), float32."""
        x = F.interpolate(self.half_size(image), scale_factor=2, mode="bilinear")
        return torch.cat([x[:, :2], log_depth_to_disparity(x[:, 2:])], dim=1)

    def scales(self, image: torch.Tensor) -> dict[str, torch.Tensor]:
        """The outputs by scale: one."""
        return {"1/1": self(image)}

    def half_size(self, image: torch.Tensor) -> torch.Tensor:
        """What the heads say, logits and unbounded depths: float32 (B, C, H/2, W/2)."""
        *skips, x = self.encoder((image * 255 - 127) / 128)
        skips.reverse()
        context = x = self.stages[0](x, skips[0])
        for stage, skip in zip(self.stages[1:], skips[1:], strict=True):
            x = stage(x, skip)
        x = self.head(x).float()
        if self.coarse_stages is None or self.coarse_head is None:
            return x  # type: ignore[no-any-return]
        coarse = context
        for stage, skip in zip(self.coarse_stages, skips[1:], strict=False):
            coarse = stage(coarse, skip)
        coarse = self.coarse_head(coarse).float()
        return x + F.interpolate(coarse, scale_factor=2, mode="bilinear")  # type: ignore[no-any-return]


def edge_network_of(weights: object) -> EdgeNetwork:
    """The network, still to be filled, that a state dict is of."""
    return EdgeNetwork(coarse_decoder=has_coarse_decoder(weights))


def has_coarse_decoder(weights: object) -> bool:
    """Whether a state dict is of a network with a coarse decoder; anything else is not."""
    return isinstance(weights, Mapping) and any(str(key).startswith("coarse_") for key in weights)


def _stages(inputs: int, skips: Sequence[int], channels: Sequence[int]) -> nn.ModuleList:
    stages = nn.ModuleList()
    for skip, outputs in zip(skips, channels, strict=False):
        stages.append(UpStage(inputs, skip, outputs))
        inputs = outputs
    return stages


def log_depth_to_disparity(x: torch.Tensor) -> torch.Tensor:
    """Unbounded output to disparity: its sigmoid runs evenly through log metres."""
    span = math.log(MAX_DEPTH_M / MIN_DEPTH_M)
    return depth_to_disparity(MIN_DEPTH_M * torch.exp(span * torch.sigmoid(x)))


def pretrained_edge_network(*, coarse_decoder: bool = False) -> EdgeNetwork:
    """A network to train: ImageNet encoder, fresh decoder.

    Raises:
        ModelError: the package with the ImageNet weights is not installed.
    """
    network = EdgeNetwork(coarse_decoder=coarse_decoder)
    network.encoder = imagenet_classifier().encoder
    return network
