"""Conversion of a network's four sigmoid maps to probabilities and metres."""

from dataclasses import dataclass

from footprints_edge.errors import ModelError
from footprints_edge.foundation.types import Floats
from footprints_edge.geometry.camera import Intrinsics, disparity_to_depth
from footprints_edge.model_files.metadata import OUTPUTS, PREFIX, ModelMetadata


@dataclass(frozen=True, eq=False)
class DecodedMaps:
    """The network's output for every pixel, in units, before any threshold.

    A map that the model file lacks is None.

    Attributes:
        visible_ground_probability: float32 (h, w), the paper's S.
        ground_probability: float32 (h, w), the paper's S*.
        visible_depth_m: float32 (h, w), the paper's D in metres.
        unmasked_ground_depth_m: float32 (h, w), the paper's D* in metres; meaningful only on
            ground.
    """

    visible_ground_probability: Floats | None
    ground_probability: Floats | None
    visible_depth_m: Floats | None
    unmasked_ground_depth_m: Floats | None


def decode_maps(maps: Floats, metadata: ModelMetadata, intrinsics: Intrinsics) -> DecodedMaps:
    """Converts the maps to probabilities and metres.

    A network infers depth from the size of objects in pixels, so its depths hold for the camera of
    its training. They scale with the focal length, by f_user / focal_px.

    Args:
        maps: float32 (1, 4, h, w), or fewer channels, see `Engine.run`.
        metadata: The model's depth range, camera and outputs.
        intrinsics: The user's camera in the pixels of (h, w).

    Raises:
        ModelError: If the number of maps differs from the metadata.
    """
    if maps.shape[1] != len(OUTPUTS[metadata.outputs]):
        raise ModelError(
            f"model {metadata.name!r} gives {maps.shape[1]} maps, but its metadata states "
            f"{PREFIX}outputs={metadata.outputs}; convert it again"
        )
    found = dict(zip(OUTPUTS[metadata.outputs], maps[0], strict=True))
    scale = 1.0 if metadata.focal_px is None else intrinsics.focal_px / metadata.focal_px
    nearest_m, farthest_m = (scale * bound for bound in metadata.depth_range_m)
    visible_depth_m, ground_depth_m = (
        disparity_to_depth(found[channel], nearest_m, farthest_m) if channel in found else None
        for channel in (2, 3)
    )
    return DecodedMaps(found.get(0), found.get(1), visible_depth_m, ground_depth_m)
