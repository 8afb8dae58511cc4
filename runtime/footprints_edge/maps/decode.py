"""From a network's four sigmoid maps to probabilities and metres."""

from dataclasses import dataclass

import numpy as np

from footprints_edge.errors import ModelError
from footprints_edge.foundation.types import Floats
from footprints_edge.geometry.camera import Intrinsics, disparity_to_depth
from footprints_edge.model_files.metadata import OUTPUTS, ModelMetadata

ABSENT: Floats = np.empty((0, 0), np.float32)
"""Stands for a map that the model file does not have."""


@dataclass(frozen=True, eq=False)
class DecodedMaps:
    """What the network says about every pixel, in units, before any threshold.

    A map that the model file does not have is `ABSENT`.

    Attributes:
        visible_ground_probability: float32 (h, w), the paper's S.
        ground_probability: float32 (h, w), the paper's S*.
        visible_depth_m: float32 (h, w), the paper's D in metres.
        unmasked_ground_depth_m: float32 (h, w), the paper's D* in metres; it means something
            only where there is ground.
    """

    visible_ground_probability: Floats
    ground_probability: Floats
    visible_depth_m: Floats
    unmasked_ground_depth_m: Floats


def postprocess(maps: Floats, metadata: ModelMetadata, intrinsics: Intrinsics) -> DecodedMaps:
    """Reads the maps in the units that the model file states.

    A network sees the size of things in pixels, so its depths are those of the camera that it
    was trained for: they grow with the focal length, by f_user / focal_px.

    Args:
        maps: float32 (1, 4, h, w), or fewer channels, see `Engine.run`.
        metadata: The model's depth range, camera and outputs.
        intrinsics: The user's camera in the pixels of (h, w).

    Raises:
        ModelError: If the maps are not as many as the metadata say.
    """
    if maps.shape[1] != len(OUTPUTS[metadata.outputs]):
        raise ModelError(
            f"model {metadata.name!r} gives {maps.shape[1]} maps, where its metadata say that it "
            f"has {metadata.outputs}; convert it again"
        )
    found = dict(zip(OUTPUTS[metadata.outputs], maps[0], strict=True))
    visible_ground, ground, *disparities = (found.get(channel, ABSENT) for channel in range(4))
    scale = 1.0 if metadata.focal_px is None else intrinsics.focal_px / metadata.focal_px
    nearest_m, farthest_m = (scale * bound for bound in metadata.depth_range_m)
    visible_depth_m, ground_depth_m = (
        ABSENT if disparity is ABSENT else disparity_to_depth(disparity, nearest_m, farthest_m)
        for disparity in disparities
    )
    return DecodedMaps(visible_ground, ground, visible_depth_m, ground_depth_m)
