"""Parity: a float32 file gives the maps of the torch network that it was exported from."""

from collections.abc import Sequence

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from footprints_edge.foundation.types import Size
from footprints_edge.model import Model
from footprints_edge.model_files.metadata import OUTPUTS
from footprints_edge_export.errors import VerificationError
from footprints_edge_export.verification.compare import CHANNELS

TOLERANCE = 1e-4
"""Largest difference allowed between torch and ONNX float32, in any pixel of any map."""


def check_parity(network: nn.Module, model: Model, sizes: Sequence[Size]) -> dict[str, float]:
    """Compare torch with a float32 file on seeded images.

    Args:
        network: RGB float32 (1, 3, H, W) in [0, 1] to maps.
        model: its file.
        sizes: (H, W) of the images.

    Returns:
        Largest difference of each map, by name.

    Raises:
        VerificationError: a map differs by more than ``TOLERANCE``.
    """
    channels = OUTPUTS[model.metadata.outputs]
    worst = np.zeros(len(channels))
    for image in seeded_images(sizes):
        x = torch.from_numpy(image).permute(0, 3, 1, 2).float() / 255
        with torch.no_grad():
            expected = network(x).numpy()
        worst = np.maximum(worst, np.abs(model.engine.run(image) - expected).max(axis=(0, 2, 3)))
    found = {CHANNELS[channel]: float(off) for channel, off in zip(channels, worst, strict=True)}
    if not worst.max() <= TOLERANCE:  # also where it is NaN
        raise VerificationError(
            f"ONNX float32 differs from torch by more than {TOLERANCE:g}: {in_short(found)}; "
            "no file was written"
        )
    return found


def seeded_images(sizes: Sequence[Size]) -> list[NDArray[np.uint8]]:
    """Smooth colour ramps with noise, uint8 (1, H, W, 3): every byte value, every frequency."""
    rng = np.random.default_rng(0)
    images = []
    for height, width in sizes:
        y, x = np.mgrid[0:height, 0:width] / max(height, width)
        ramps = np.stack([x, y, 1 - (x + y) / 2], axis=-1) * 200
        image = (ramps + rng.integers(0, 56, (height, width, 3))).astype(np.uint8)[None]
        images.append(image)
    return images


def in_short(differences: dict[str, float]) -> str:
    """Differences by map, in one line."""
    return ", ".join(f"{name} {value:.2g}" for name, value in differences.items())
