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
from footprints_edge_models.networks.registry import NETWORKS


@dataclass(frozen=True)
class Architecture:
    """What an export needs to know about a network.

    Attributes:
        build: makes the network, untrained. It takes RGB float32 (B, 3, H, W) in [0, 1], H and W
            multiples of 32, and gives the raw channels of
            ``footprints_edge_models.networks.channels``.
        build_for: makes the network, to be filled, that a state dict is of.
        focal_px: focal length of its canonical camera, where a checkpoint states none; None where
            depths are as trained.
        licence: licence of its weights, if the caller states none.
        notice: what users of its weights must know; each conversion prints it once.
        part: makes the network that gives some of the maps, or those of a coarser head; it takes
            the whole network, a key of ``footprints_edge.model_files.metadata.OUTPUTS`` and the
            decoder scale.
        scales: decoder scales; a head of scale 4 has a quarter of the image's sides.
        resize: filter that its files ask for, a key of
            ``footprints_edge.inputs.preprocessing.FILTERS``.
    """

    build: Callable[[], nn.Module]
    build_for: Callable[[object], nn.Module]
    part: Callable[[Any, str, int], nn.Module]
    scales: tuple[int, ...]
    focal_px: float | None
    licence: str
    notice: str
    resize: str


def _architecture(name: str, part: type[EdgePart | ReferencePart], resize: str) -> Architecture:
    spec = NETWORKS[name]
    return Architecture(
        spec.build,
        spec.build_for,
        part,
        part.SCALES,
        spec.focal_px,
        spec.licence,
        spec.notice,
        resize,
    )


ARCHITECTURES = {
    # less than half of Lanczos's time, for the same accuracy: docs/latency.md
    "edge": _architecture("edge", EdgePart, "hamming"),
    "reference": _architecture("reference", ReferencePart, "lanczos"),
}
"""By name; what a network is, says ``footprints_edge_models.networks.registry``."""


def trained(architecture: str, checkpoint: Path) -> nn.Module:
    """Load a network with its weights, for inference.

    Args:
        architecture: key of ``ARCHITECTURES``.
        checkpoint: file of a PyTorch state dict.

    Raises:
        ModelError: the checkpoint does not fit the architecture.
    """
    weights = read_checkpoint(checkpoint)
    network = ARCHITECTURES[architecture].build_for(weights).eval()
    load_weights(network, weights, str(checkpoint))
    return network


def canonical_focal_px(architecture: str, checkpoint: Path) -> float | None:
    """Focal length of the camera that a checkpoint's depths are for; None: depths are as trained.

    Raises:
        ModelError: the checkpoint states one that is no focal length.
    """
    stated = stated_focal_px(read_checkpoint(checkpoint), str(checkpoint))
    return ARCHITECTURES[architecture].focal_px if stated is None else stated
