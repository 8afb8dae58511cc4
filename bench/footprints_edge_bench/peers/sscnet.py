"""SSCNet (Song et al. 2017): 3D convolutions on 240x144x240 voxels, and the encoding before them.

Layers, widths and dilations are those of the paper's figure 3.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from footprints_edge.foundation.types import Floats, Size
from footprints_edge_bench.peers.made_depth import DEPTH_SIZE, depth_camera, room_depth_m
from footprints_edge_bench.peers.peer import Peer, PeerNetwork
from footprints_edge_bench.peers.tsdf import flipped_tsdf

if TYPE_CHECKING:
    from torch import Tensor


@dataclass(frozen=True)
class SscNetShape:
    """Sizes of the network; the defaults are the paper's.

    Attributes:
        grid: voxels across, up, and ahead.
        voxel_m: side of a voxel.
        widths: channels at a half and at a quarter of the grid's sides, and of the last layers.
        classes: 11 kinds of things, and empty.
    """

    grid: tuple[int, int, int] = (240, 144, 240)
    voxel_m: float = 0.02
    widths: tuple[int, int, int] = (32, 64, 128)
    classes: int = 12


def sscnet(shape: SscNetShape = SscNetShape(), depth_size: Size = DEPTH_SIZE) -> Peer:
    """The peer, on a depth picture of a made room."""
    depth_m, camera = room_depth_m(depth_size), depth_camera(depth_size)

    def prepare() -> Floats:
        return flipped_tsdf(depth_m, camera, shape.grid, shape.voxel_m)[None, None]

    return Peer(
        "Voxels (SSCNet)",
        lambda: _networks(shape),
        prepare,
        lambda runs, voxels: runs["voxels"](voxels),
        "estimating the room's axes, to turn the voxels into them; projecting the floor's voxels "
        "into the picture",
    )


def _networks(shape: SscNetShape) -> Mapping[str, PeerNetwork]:
    import torch
    from torch import nn

    near, far, last = shape.widths

    class Residual(nn.Module):
        def __init__(self, before: int, width: int, dilation: int = 1) -> None:
            super().__init__()
            self.inner = nn.Sequential(
                nn.Conv3d(before, width, 3, 1, dilation, dilation),
                nn.ReLU(),
                nn.Conv3d(width, width, 3, 1, dilation, dilation),
            )
            self.skip = nn.Conv3d(before, width, 1) if before != width else nn.Identity()

        def forward(self, x: "Tensor") -> "Tensor":
            return (self.inner(x) + self.skip(x)).relu()  # type: ignore[no-any-return]

    class SscNet(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.start = nn.Sequential(
                nn.Conv3d(1, near // 2, 7, 2, 3),
                nn.ReLU(),
                Residual(near // 2, near),
                nn.MaxPool3d(2),
            )
            self.context = nn.ModuleList(
                [
                    Residual(near, far),
                    Residual(far, far),
                    Residual(far, far, dilation=2),
                    Residual(far, far, dilation=2),
                ]
            )
            self.end = nn.Sequential(
                nn.Conv3d(4 * far, last, 1),
                nn.ReLU(),
                nn.Conv3d(last, last, 1),
                nn.ReLU(),
                nn.Conv3d(last, shape.classes, 1),
            )

        def forward(self, x: "Tensor") -> "tuple[Tensor]":
            x = self.start(x)
            found = []
            for block in self.context:
                x = block(x)
                found.append(x)
            return (self.end(torch.cat(found, 1)),)

    torch.manual_seed(0)
    return {"voxels": PeerNetwork(SscNet().eval(), (np.zeros((1, 1, *shape.grid), np.float32),))}
