"""The networks by name. To add one, write its module and its row in ``NETWORKS``."""

from collections.abc import Callable
from dataclasses import dataclass

from footprints_edge_models.networks.edge import (
    FOCAL_PX,
    EdgeNetwork,
    edge_network_of,
    pretrained_edge_network,
)
from footprints_edge_models.networks.reference import ReferenceNetwork

Network = EdgeNetwork | ReferenceNetwork
"""RGB float32 (B, 3, H, W) in [0, 1], H and W multiples of 32, to raw channels (B, 4, H, W), see
:mod:`channels`; ``encoder`` is the part that may come pretrained, ``scales`` gives all outputs."""


@dataclass(frozen=True)
class NetworkSpec:
    """A network, for training and for export.

    Attributes:
        name: as options and checkpoints name it.
        build: makes the network with random weights.
        build_for: makes the network, to be filled, that a state dict is of.
        focal_px: focal length of the canonical camera that its depths are for, in pixels of its
            input; None where depths are as trained.
        licence: of its weights, where the caller states none.
        pretrained: makes the network to begin training with, its encoder pretrained; None where
            training begins with random weights.
        notice: what users of its weights must know, said once at each conversion.
    """

    name: str
    build: Callable[..., Network]
    build_for: Callable[[object], Network]
    focal_px: float | None
    licence: str
    pretrained: Callable[..., Network] | None = None
    notice: str = ""


NETWORKS = {
    spec.name: spec
    for spec in (
        NetworkSpec(
            "edge", EdgeNetwork, edge_network_of, FOCAL_PX, "unstated", pretrained_edge_network
        ),
        NetworkSpec(
            "reference",
            ReferenceNetwork,
            lambda _: ReferenceNetwork(),
            None,
            "Niantic Footprints licence: non-commercial use only",
            notice="The published checkpoints are licensed for non-commercial use only and may "
            "not be redistributed; cite Watson et al., Footprints and Free Space from a Single "
            "Color Image, CVPR 2020.",
        ),
    )
}
"""By name."""
