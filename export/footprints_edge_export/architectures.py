"""The networks that can be exported. To add one, add its row to ``ARCHITECTURES``."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from torch import nn

from footprints_edge_export.partial_networks import EdgePart, ReferencePart
from footprints_edge_models.networks.checkpoint import (
    load_weights,
    read_checkpoint,
    stated_focal_px,
)
from footprints_edge_models.networks.registry import NETWORKS, NetworkSpec


@dataclass(frozen=True)
class Architecture:
    """What an export needs to know about a network.

    Attributes:
        network: what training knows about it, too.
        part: makes the network that gives some of the maps, or those of a coarser head; it takes
            the whole network, a key of ``footprints_edge.model_files.metadata.OUTPUTS`` and the
            decoder scale.
        scales: decoder scales; a head of scale 4 has a quarter of the image's sides.
        resize: filter that its files ask for, a key of
            ``footprints_edge.inputs.preprocessing.FILTERS``.
    """

    network: NetworkSpec
    part: Callable[[Any, str, int], nn.Module]
    scales: tuple[int, ...]
    resize: str


ARCHITECTURES = {
    # less than half of Lanczos's time, for the same accuracy: docs/latency.md
    "edge": Architecture(NETWORKS["edge"], EdgePart, EdgePart.SCALES, "hamming"),
    "reference": Architecture(
        NETWORKS["reference"], ReferencePart, ReferencePart.SCALES, "lanczos"
    ),
}
"""By name."""


def trained(architecture: str, checkpoint: Path) -> nn.Module:
    """Load a network with its weights, for inference.

    Args:
        architecture: key of ``ARCHITECTURES``.
        checkpoint: file of a PyTorch state dict.

    Raises:
        ModelError: the checkpoint does not fit the architecture.
    """
    weights = read_checkpoint(checkpoint)
    network = ARCHITECTURES[architecture].network.build_for(weights).eval()
    load_weights(network, weights, str(checkpoint))
    return network


def canonical_focal_px(architecture: str, checkpoint: Path) -> float | None:
    """Focal length of the camera that a checkpoint's depths are for; None: depths are as trained.

    Raises:
        ModelError: the checkpoint states one that is no focal length.
    """
    stated = stated_focal_px(read_checkpoint(checkpoint), str(checkpoint))
    return ARCHITECTURES[architecture].network.focal_px if stated is None else stated
