"""The paper's own network, laid out so that the published checkpoints load strictly.

A ResNet-34 encoder and two skip decoders of the same shape, one for the masks and one for the
depths (paper, "Implementation details"; layout and behaviour as in the published implementation).
"""

import torch
import torch.nn.functional as F
from torch import nn

SCALES = ("1/1", "1/2", "1/4", "1/8")
ENCODER_CHANNELS = (64, 64, 128, 256, 512)


class BasicBlock(nn.Module):
    """ResNet's block of two 3x3 convolutions with a shortcut."""

    def __init__(self, inputs: int, outputs: int, stride: int) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False)
        self.bn1 = nn.BatchNorm2d(outputs)
        self.conv2 = nn.Conv2d(outputs, outputs, 3, 1, 1, bias=False)
        self.bn2 = nn.BatchNorm2d(outputs)
        self.downsample: nn.Module | None = None
        if stride != 1 or inputs != outputs:
            self.downsample = nn.Sequential(
                nn.Conv2d(inputs, outputs, 1, stride, bias=False), nn.BatchNorm2d(outputs)
            )

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """(B, inputs, H, W) to (B, outputs, H/stride, W/stride)."""
        shortcut = x if self.downsample is None else self.downsample(x)
        x = F.relu(self.bn1(self.conv1(x)))
        return F.relu(self.bn2(self.conv2(x)) + shortcut)


class Encoder(nn.Module):
    """ResNet-34 up to its fourth layer: five features at 1/2, 1/4, 1/8, 1/16 and 1/32."""

    def __init__(self) -> None:
        super().__init__()
        self.layer0 = nn.Sequential(
            nn.Conv2d(3, 64, 7, 2, 3, bias=False), nn.BatchNorm2d(64), nn.ReLU()
        )
        self.layer1 = nn.Sequential(nn.MaxPool2d(3, 2, 1), _layer(64, 64, blocks=3, stride=1))
        self.layer2 = _layer(64, 128, blocks=4, stride=2)
        self.layer3 = _layer(128, 256, blocks=6, stride=2)
        self.layer4 = _layer(256, 512, blocks=3, stride=2)

    def forward(self, image: torch.Tensor) -> list[torch.Tensor]:
        """RGB (B, 3, H, W) in [0, 1] to the five features, finest first."""
        features = [self.layer0((image - 0.45) / 0.225)]
        for layer in (self.layer1, self.layer2, self.layer3, self.layer4):
            features.append(layer(features[-1]))
        return features


def _layer(inputs: int, outputs: int, *, blocks: int, stride: int) -> nn.Sequential:
    first = BasicBlock(inputs, outputs, stride)
    return nn.Sequential(first, *(BasicBlock(outputs, outputs, 1) for _ in range(blocks - 1)))


class ReflectConv(nn.Module):
    """A 3x3 convolution with reflection padding and bias."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, outputs, 3, padding=1, padding_mode="reflect")

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """(B, inputs, H, W) to (B, outputs, H, W)."""
        return self.conv1(x)  # type: ignore[no-any-return]


class ConvPair(nn.Module):
    """Two reflection-padded 3x3 convolutions, each followed by ELU.

    The published checkpoints hold batch norms for every pair, which the published network never
    applies; they are here so that a checkpoint loads strictly, and are not applied either.
    """

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.conv1 = nn.Conv2d(inputs, outputs, 3, padding=1, padding_mode="reflect")
        self.bn1 = nn.BatchNorm2d(outputs)
        self.conv2 = nn.Conv2d(outputs, outputs, 3, padding=1, padding_mode="reflect")
        self.bn2 = nn.BatchNorm2d(outputs)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """(B, inputs, H, W) to (B, outputs, H, W)."""
        return F.elu(self.conv2(F.elu(self.conv1(x))))


class UpBlock(nn.Module):
    """Conv pair, nearest x2, concatenation with the encoder's feature, conv pair."""

    def __init__(self, inputs: int, outputs: int) -> None:
        super().__init__()
        self.pre_concat_conv = ConvPair(inputs, outputs)
        self.post_concat_conv = ConvPair(2 * outputs, outputs)

    def forward(self, x: torch.Tensor, skip: torch.Tensor) -> torch.Tensor:
        """(B, inputs, H, W) and skip (B, outputs, 2H, 2W) to (B, outputs, 2H, 2W)."""
        x = F.interpolate(self.pre_concat_conv(x), scale_factor=2, mode="nearest")
        return self.post_concat_conv(torch.cat([x, skip], dim=1))  # type: ignore[no-any-return]


class Decoder(nn.Module):
    """Two output channels at 1/1, and side outputs at 1/2, 1/4 and 1/8."""

    def __init__(self) -> None:
        super().__init__()
        self.block1 = UpBlock(512, 256)
        self.block2 = UpBlock(256, 128)
        self.block3 = UpBlock(128, 64)
        self.block4 = UpBlock(64, 64)
        self.outconv1 = ReflectConv(128, 2)
        self.outconv2 = ReflectConv(64, 2)
        self.outconv3 = ReflectConv(64, 2)
        self.outconv4 = nn.Sequential(ConvPair(64, 32), ReflectConv(32, 2))

    def forward(self, features: list[torch.Tensor]) -> dict[str, torch.Tensor]:
        """The encoder's five features to (B, 2, H/s, W/s) a scale."""
        half, quarter, eighth, sixteenth, last = features
        x = self.block1(last, sixteenth)
        x = self.block2(x, eighth)
        outputs = {"1/8": self.outconv1(x)}
        x = self.block3(x, quarter)
        outputs["1/4"] = self.outconv2(x)
        x = self.block4(x, half)
        outputs["1/2"] = self.outconv3(x)
        outputs["1/1"] = self.outconv4(F.interpolate(x, scale_factor=2, mode="nearest"))
        return outputs


class ReferenceNetwork(nn.Module):
    """The published network: RGB (B, 3, H, W) in [0, 1], H and W multiples of 32."""

    def __init__(self) -> None:
        super().__init__()
        self.encoder = Encoder()
        self.mask_decoder = Decoder()
        self.depth_decoder = Decoder()

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        """Raw channels (B, 4, H, W) at full resolution (see :mod:`channels`)."""
        return self.scales(image)["1/1"]

    def scales(self, image: torch.Tensor) -> dict[str, torch.Tensor]:
        """Raw channels (B, 4, H, W) from each of the four outputs, all at the image's size.

        Side outputs are resized bilinearly; the sigmoid of a disparity comes before the resize.
        """
        features = self.encoder(image)
        masks, depths = self.mask_decoder(features), self.depth_decoder(features)
        size = image.shape[-2:]
        raw = {
            s: torch.cat([masks[s].float(), torch.sigmoid(depths[s].float())], dim=1)
            for s in SCALES
        }
        return {
            s: x if x.shape[-2:] == size else F.interpolate(x, size, mode="bilinear")
            for s, x in raw.items()
        }
