"""VoteNet (Qi et al. 2019): a PointNet++ backbone on 20,000 points, votes, and 256 proposals.

Layers, widths, radii and numbers of samples are those of the paper's section 4 and appendix.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from footprints_edge.foundation.types import Floats, Size
from footprints_edge_bench.peers.made_depth import DEPTH_SIZE, depth_camera, room_depth_m
from footprints_edge_bench.peers.peer import Arrays, Peer, PeerNetwork, Run
from footprints_edge_bench.peers.point_sets import ball_query, farthest_points, three_nearest

if TYPE_CHECKING:
    from torch import Tensor


@dataclass(frozen=True)
class Abstraction:
    """A set abstraction layer: so many centres, and so many points within a radius of each."""

    centres: int
    radius_m: float
    samples: int
    widths: tuple[int, int, int]


@dataclass(frozen=True)
class VoteNetShape:
    """Sizes of the network; the defaults are the paper's for SUN RGB-D.

    Attributes:
        points: number of input points.
        layers: the backbone's four set abstraction layers.
        proposals: number of boxes, by another set abstraction layer on the votes.
        width: channels of seeds and votes.
        outputs: channels of a box: 2 of objectness, 3 of its centre, 12 headings and 10 sizes with
            their residuals (2 and 4 channels each), and 10 classes.
    """

    points: int = 20_000
    layers: tuple[Abstraction, ...] = (
        Abstraction(2048, 0.2, 64, (64, 64, 128)),
        Abstraction(1024, 0.4, 32, (128, 128, 256)),
        Abstraction(512, 0.8, 16, (128, 128, 256)),
        Abstraction(256, 1.2, 16, (128, 128, 256)),
    )
    proposals: Abstraction = Abstraction(256, 0.3, 16, (128, 128, 128))
    width: int = 256
    outputs: int = 2 + 3 + 12 * 2 + 10 * 4 + 10


def votenet(shape: VoteNetShape = VoteNetShape(), depth_size: Size = DEPTH_SIZE) -> Peer:
    """The peer, on a depth picture of a made room."""
    depth_m = room_depth_m(depth_size)
    return Peer(
        "Bounding box (Qi et al.)",
        lambda: _networks(shape),
        lambda: _sampled(depth_m, depth_size, shape.points),
        lambda runs, points: _infer(runs, points, shape),
        "suppression of boxes that overlap in 3D; turning the camera's points upright",
    )


def _sampled(depth_m: Floats, size: Size, count: int) -> Floats:
    """Random points of a depth picture, float32 (count, 3), in camera axes."""
    camera = depth_camera(size)
    chosen = np.random.default_rng(0).choice(depth_m.size, count, replace=depth_m.size < count)
    rows, columns = np.divmod(chosen, size[1])
    depth = depth_m.take(chosen)
    x, y = (columns - camera.cx) / camera.fx * depth, (rows - camera.cy) / camera.fy * depth
    return np.stack([x, y, depth], 1).astype(np.float32)


def _grouped(points: Floats, centres: Floats, layer: Abstraction) -> Arrays:
    """Indices (m, k) of the points of each centre, and their offsets (1, 3, m, k) by radius."""
    index = ball_query(points, centres, layer.radius_m, layer.samples)
    offsets = (points[index] - centres[:, None]) / np.float32(layer.radius_m)
    return index, np.ascontiguousarray(offsets.transpose(2, 0, 1)[None])


def _infer(runs: Mapping[str, Run], points: Floats, shape: VoteNetShape) -> Arrays:
    """One frame: votes and proposals, with all sampling, grouping and interpolation between."""
    floor_y = np.percentile(points[:, 1], 99)  # y is down
    places, inputs = [points], []
    for layer in shape.layers:
        centres = places[-1][farthest_points(places[-1], layer.centres)]
        inputs.append(_grouped(places[-1], centres, layer))
        places.append(centres)
    (first, offsets), *others = inputs
    height = (floor_y - points[:, 1]).astype(np.float32)[first][None, None]
    back = [
        three_nearest(places[-1 - up], places[-2 - up])  # from the coarsest to the seeds
        for up in range(2)
    ]
    moves, features = runs["votes"](
        np.concatenate([offsets, height], 1), *(each for pair in (*others, *back) for each in pair)
    )
    votes = places[2] + moves[0].T
    layer = shape.proposals
    chosen = votes[farthest_points(votes, layer.centres)]
    return runs["proposals"](features, *_grouped(votes, chosen, layer))


def _networks(shape: VoteNetShape) -> Mapping[str, PeerNetwork]:
    import torch
    from torch import nn

    def points_mlp(*widths: int) -> nn.Sequential:
        layers: list[nn.Module] = []
        for before, after in pairwise(widths):
            layers += [nn.Conv2d(before, after, 1, bias=False), nn.BatchNorm2d(after), nn.ReLU()]
        return nn.Sequential(*layers)

    def seeds_mlp(*widths: int, last: int) -> nn.Sequential:
        layers: list[nn.Module] = []
        for before, after in pairwise(widths):
            layers += [nn.Conv1d(before, after, 1, bias=False), nn.BatchNorm1d(after), nn.ReLU()]
        return nn.Sequential(*layers, nn.Conv1d(widths[-1], last, 1))

    def interpolated(x: "Tensor", index: "Tensor", weight: "Tensor") -> "Tensor":
        return (x[:, :, index] * weight).sum(-1)

    width = shape.width

    class Votes(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            before = [1, *(layer.widths[-1] for layer in shape.layers[:-1])]
            self.abstraction = nn.ModuleList(
                points_mlp(3 + channels, *layer.widths)
                for channels, layer in zip(before, shape.layers, strict=True)
            )
            wide = [layer.widths[-1] for layer in shape.layers]
            self.up = nn.ModuleList(
                [
                    points_mlp(wide[3] + wide[2], width, width),
                    points_mlp(width + wide[1], width, width),
                ]
            )
            self.vote = seeds_mlp(width, width, width, last=3 + width)

        def forward(self, points: "Tensor", *given: "Tensor") -> "tuple[Tensor, Tensor]":
            found = [self.abstraction[0](points).amax(-1)]
            for layer, index, offsets in zip(
                list(self.abstraction)[1:], given[0:6:2], given[1:6:2], strict=True
            ):
                grouped = torch.cat([offsets, found[-1][:, :, index]], 1)
                found.append(layer(grouped).amax(-1))
            x = found[3]
            for mlp, skip, index, weight in zip(
                self.up, (found[2], found[1]), given[6::2], given[7::2], strict=True
            ):
                both = torch.cat([interpolated(x, index, weight), skip], 1)
                x = mlp(both[..., None])[..., 0]
            moved = self.vote(x)
            votes = x + moved[:, 3:]
            return moved[:, :3], votes / (votes.norm(dim=1, keepdim=True) + 1e-6)

    class Proposals(nn.Module):
        def __init__(self) -> None:
            super().__init__()
            widths = shape.proposals.widths
            self.abstraction = points_mlp(3 + width, *widths)
            self.box = seeds_mlp(widths[-1], widths[-1], widths[-1], last=shape.outputs)

        def forward(self, votes: "Tensor", index: "Tensor", offsets: "Tensor") -> "tuple[Tensor]":
            grouped = torch.cat([offsets, votes[:, :, index]], 1)
            return (self.box(self.abstraction(grouped).amax(-1)),)

    torch.manual_seed(0)
    votes, proposals = Votes().eval(), Proposals().eval()
    return {
        "votes": PeerNetwork(votes, _vote_examples(shape)),
        "proposals": PeerNetwork(
            proposals,
            (
                np.zeros((1, width, shape.layers[1].centres), np.float32),
                *_group_examples(shape.proposals),
            ),
        ),
    }


def _group_examples(layer: Abstraction) -> Arrays:
    return (
        np.zeros((layer.centres, layer.samples), np.int64),
        np.zeros((1, 3, layer.centres, layer.samples), np.float32),
    )


def _vote_examples(shape: VoteNetShape) -> Arrays:
    first, *others = shape.layers
    examples: list[np.ndarray] = [np.zeros((1, 4, first.centres, first.samples), np.float32)]
    for layer in others:
        examples += _group_examples(layer)
    for targets in (shape.layers[2].centres, shape.layers[1].centres):
        examples += [np.zeros((targets, 3), np.int64), np.zeros((targets, 3), np.float32)]
    return tuple(examples)
