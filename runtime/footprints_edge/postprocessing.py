"""From a network's four sigmoid maps to probabilities and metres."""

from dataclasses import dataclass

from footprints_edge.arrays import Floats
from footprints_edge.geometry import Intrinsics, disparity_to_depth
from footprints_edge.metadata import ModelMetadata


@dataclass(frozen=True, eq=False)
class DecodedMaps:
    """What the network says about every pixel, in units, before any threshold.

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
        maps: float32 (1, 4, h, w), see `Session.run`.
        metadata: The model's depth range and camera.
        intrinsics: The user's camera in the pixels of (h, w).
    """
    visible_ground, ground, visible_disparity, ground_disparity = maps[0]
    scale = 1.0 if metadata.focal_px is None else intrinsics.focal_px / metadata.focal_px
    nearest_m, farthest_m = (scale * bound for bound in metadata.depth_range_m)
    return DecodedMaps(
        visible_ground,
        ground,
        disparity_to_depth(visible_disparity, nearest_m, farthest_m),
        disparity_to_depth(ground_disparity, nearest_m, farthest_m),
    )
