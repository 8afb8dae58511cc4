"""Predictions without a model: a factory for all tests."""

import numpy as np

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import DecodedImage
from footprints_edge.maps.decode import DecodedMaps
from footprints_edge.maps.ground_maps import ModelInfo
from footprints_edge.prediction import Prediction

MODEL = ModelInfo("stub", "fp32", "0" * 64, "none")


def make_prediction(
    depth_m,
    *,
    ground=None,
    visible_ground=None,
    visible_depth_m=None,
    intrinsics=None,
    picture=None,
    name=None,
    outputs="all",
):
    """A prediction whose maps are the given ones.

    Args:
        depth_m: (h, w), metres to the ground.
        ground: Probability (h, w). Default: 1 everywhere.
        visible_ground: Probability (h, w). Default: `ground`.
        visible_depth_m: (h, w), metres. Default: `depth_m`.
        intrinsics: Camera in pixels of the maps. Default: a centred camera.
        picture: uint8 (H, W, 3), or the (H, W) of a black picture. Default: the maps' size.
        name: File name of the picture.
        outputs: Maps that the model has: `all`, `masks` or `depths`.
    """
    depth_m = np.asarray(depth_m, np.float32)
    size = depth_m.shape
    ground = np.ones(size) if ground is None else ground
    visible_ground = ground if visible_ground is None else visible_ground
    visible_depth_m = depth_m if visible_depth_m is None else visible_depth_m
    if not isinstance(picture, np.ndarray):
        picture = np.zeros((*(picture or size), 3), np.uint8)
    has_masks, has_depths = outputs != "depths", outputs != "masks"
    maps = DecodedMaps(
        np.asarray(visible_ground, np.float32) if has_masks else None,
        np.asarray(ground, np.float32) if has_masks else None,
        np.asarray(visible_depth_m, np.float32) if has_depths else None,
        depth_m if has_depths else None,
    )
    camera = intrinsics or Intrinsics.from_focal_px(size[1], size)
    return Prediction(maps, DecodedImage(picture, name), camera, 0.5, MODEL)
