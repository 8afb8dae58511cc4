"""3D boxes from crops (Mousavian et al. 2017): a 2D detector, then VGG-19 on each box found.

The crop's network is the paper's section 5: the convolutions of VGG-19 on 224x224, and three
branches of fully connected layers. The 2D detector is YOLOv3 (Redmon and Farhadi 2018, table 1) at
416x416, which users of the method commonly take; the paper's own is slower.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image

from footprints_edge.foundation.types import Floats, Rgb, Size
from footprints_edge_bench.peers.peer import Arrays, Peer, PeerNetwork, Run

if TYPE_CHECKING:
    from torch import Tensor

KITTI_SIZE: Size = (375, 1242)

BOXES = 4
"""KITTI's training set for detection has 28,742 cars in 7,481 pictures: 3.8 in each."""


@dataclass(frozen=True)
class CropsShape:
    """Sizes of the networks; the defaults are those of the papers.

    Attributes:
        detector_px: side of the detector's input.
        stages: residual blocks of the detector's five stages.
        width: channels of the detector's first convolution.
        crop_px: side of a crop.
        vgg: convolutions of each of the crop network's five stages, and their channels.
        hidden: widths of the fully connected layers: orientation and confidence, dimensions.
    """

    detector_px: int = 416
    stages: tuple[int, ...] = (1, 2, 8, 8, 4)
    width: int = 32
    crop_px: int = 224
    vgg: tuple[tuple[int, int], ...] = ((2, 64), (2, 128), (4, 256), (4, 512), (4, 512))
    hidden: tuple[int, int] = (256, 512)


def mousavian(shape: CropsShape = CropsShape(), size: Size = KITTI_SIZE) -> Peer:
    """The peer, on noise of the size of a picture of KITTI."""
    picture = np.random.default_rng(0).integers(0, 256, (*size, 3), np.uint8)
    return Peer(
        "Bounding box (Mousavian et al.)",
        lambda: _networks(shape),
        lambda: picture,
        lambda runs, rgb: _infer(runs, rgb, shape),
        f"choosing boxes among those that overlap ({BOXES} are cropped, the cars of a picture of "
        "KITTI on average), and solving for the place of each",
    )


def _infer(runs: Mapping[str, Run], rgb: Rgb, shape: CropsShape) -> Arrays:
    image = Image.fromarray(rgb)
    detected = runs["detector"](_planes(image, shape.detector_px))
    height, width = rgb.shape[:2]
    sides = height // 3
    crops = [
        _planes(image.crop((left, sides, left + sides, 2 * sides)), shape.crop_px)
        for left in np.linspace(0, width - sides, BOXES).astype(int).tolist()
    ]
    return (*detected, *runs["crops"](np.concatenate(crops)))


def _planes(image: Image.Image, side: int) -> Floats:
    """float32 (1, 3, side, side), standardised."""
    pixels = np.asarray(image.resize((side, side), Image.Resampling.BILINEAR), np.float32)
    return np.ascontiguousarray(((pixels - 114.75) / 57.4).transpose(2, 0, 1)[None])


def _networks(shape: CropsShape) -> Mapping[str, PeerNetwork]:
    import torch
    from torch import nn

    def conv(before: int, after: int, side: int, stride: int = 1) -> nn.Sequential:
        return nn.Sequential(
            nn.Conv2d(before, after, side, stride, side // 2, bias=False),
            nn.BatchNorm2d(after),
            nn.LeakyReLU(0.1),
        )

    class Residual(nn.Module):
        def __init__(self, width: int) -> None:
            super().__init__()
            self.inner = nn.Sequential(conv(width, width // 2, 1), conv(width // 2, width, 3))

        def forward(self, x: "Tensor") -> "Tensor":
            return x + self.inner(x)  # type: ignore[no-any-return]

    def five(before: int, width: int) -> nn.Sequential:
        return nn.Sequential(
            conv(before, width, 1),
            conv(width, 2 * width, 3),
            conv(2 * width, width, 1),
            conv(width, 2 * width, 3),
            conv(2 * width, width, 1),
        )

    class Detector(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            width = shape.width
            self.stem = conv(3, width, 3)
            stages = []
            for blocks in shape.stages:
                residuals = (Residual(2 * width) for _ in range(blocks))
                stages.append(nn.Sequential(conv(width, 2 * width, 3, 2), *residuals))
                width *= 2
            self.stages = nn.ModuleList(stages)
            wide = width // 2
            self.five = nn.ModuleList(
                [
                    five(width, wide),
                    five(wide + wide // 2, wide // 2),
                    five(3 * wide // 4, wide // 4),
                ]
            )
            self.lateral = nn.ModuleList([conv(wide, wide // 2, 1), conv(wide // 2, wide // 4, 1)])
            self.heads = nn.ModuleList(
                nn.Sequential(conv(each, 2 * each, 3), nn.Conv2d(2 * each, 3 * (5 + 80), 1))
                for each in (wide, wide // 2, wide // 4)
            )

        def forward(self, x: "Tensor") -> "tuple[Tensor, ...]":
            x = self.stem(x)
            found = []
            for stage in self.stages:
                x = stage(x)
                found.append(x)
            x = self.five[0](x)
            outputs = [self.heads[0](x)]
            for lateral, block, head, skip in zip(
                self.lateral,
                list(self.five)[1:],
                list(self.heads)[1:],
                found[-2:-4:-1],
                strict=True,
            ):
                upsampled = nn.functional.interpolate(lateral(x), scale_factor=2)
                x = block(torch.cat([upsampled, skip], 1))
                outputs.append(head(x))
            return tuple(outputs)

    def branch(before: int, hidden: int, outputs: int) -> nn.Sequential:
        return nn.Sequential(
            nn.Linear(before, hidden),
            nn.ReLU(),
            nn.Linear(hidden, hidden),
            nn.ReLU(),
            nn.Linear(hidden, outputs),
        )

    class Crops(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            layers: list[nn.Module] = []
            before = 3
            for count, width in shape.vgg:
                for _ in range(count):
                    layers += [nn.Conv2d(before, width, 3, 1, 1), nn.ReLU()]
                    before = width
                layers.append(nn.MaxPool2d(2))
            self.features = nn.Sequential(*layers, nn.Flatten())
            flat = before * (shape.crop_px // 2 ** len(shape.vgg)) ** 2
            first, second = shape.hidden
            self.branches = nn.ModuleList(
                [branch(flat, first, 2 * 2), branch(flat, first, 2), branch(flat, second, 3)]
            )  # sine and cosine of the angle in each of two bins; the bins; the dimensions

        def forward(self, x: "Tensor") -> "tuple[Tensor, ...]":
            x = self.features(x)
            return tuple(each(x) for each in self.branches)

    torch.manual_seed(0)
    detector, crops = shape.detector_px, shape.crop_px
    return {
        "detector": PeerNetwork(
            Detector().eval(), (np.zeros((1, 3, detector, detector), np.float32),)
        ),
        "crops": PeerNetwork(Crops().eval(), (np.zeros((BOXES, 3, crops, crops), np.float32),)),
    }
