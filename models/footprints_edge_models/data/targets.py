"""What the loss asks of a batch: labels, weights of the three pixel sets of eq. 3, and depths."""

from dataclasses import dataclass, fields

import torch

LAMBDA = 0.25
"""The paper's lambda (eq. 3c): how strongly unknown pixels count as untraversable."""
UNLIKELY_WEIGHT = 0.25
"""Weight of eq. 3c on pixels whose class seldom has ground behind it: a photo shows what stands
there, and nobody has looked behind."""
FOOTPRINT_WEIGHT = 3.0
"""Weight of eq. 3b on footprints: few pixels, and the ones that a path must avoid."""


@dataclass(frozen=True)
class Targets:
    """Targets of a batch; every tensor is float32 (B, H, W).

    The three pixel sets of the paper are ``ground`` (traversable), ``untraversable`` and the rest,
    the unknown pixels.

    Attributes:
        visible_ground: 1 where the surface seen is walkable, 0 where not.
        visible_ground_valid: valid mask of ``visible_ground``: 1 where there is a label.
        ground: 1 on pixels known to be traversable, seen or hidden.
        ground_weight: weight of eq. 3a on these pixels, 0 elsewhere.
        untraversable: weight of eq. 3b on pixels known to be untraversable, 0 elsewhere.
        unknown_weight: weight of eq. 3c on the unknown pixels: lambda where a video covers the
            place and no frame saw ground there, ``UNLIKELY_WEIGHT`` behind what seldom hides
            ground, 0 where nothing is known.
        moving: 1 on moving objects (the paper's 1 - mu), whose hidden ground is not learned.
        visible_depth_m: metres, 0 where unknown.
        ground_depth_m: metres, 0 where unknown or not ground.
    """

    visible_ground: torch.Tensor
    visible_ground_valid: torch.Tensor
    ground: torch.Tensor
    ground_weight: torch.Tensor
    untraversable: torch.Tensor
    unknown_weight: torch.Tensor
    moving: torch.Tensor
    visible_depth_m: torch.Tensor
    ground_depth_m: torch.Tensor

    def to(self, device: torch.device) -> "Targets":
        """The same on another device."""
        return Targets(
            **{
                field.name: getattr(self, field.name).to(device, non_blocking=True)
                for field in fields(self)
            }
        )
