"""The paper's baselines (section "Experiments", "Baselines"), one row of its tables each.

Baselines that start from visible ground or depth use the predictions of the first model.
"""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from footprints_edge.foundation.types import Floats, Mask, Size
from footprints_edge.geometry.camera import Intrinsics, backproject, rays
from footprints_edge.prediction import Prediction
from footprints_edge_bench.geometry.boxes import Box
from footprints_edge_bench.geometry.convex_hull import convex_hull
from footprints_edge_bench.geometry.voxels import VoxelGrid
from footprints_edge_bench.ground_truth.base import GroundTruth

NOTHING, EVERYTHING = "Nothing traversable", "Everything traversable"
HULL, BOXES, PROJECT_DOWN = "Convex hull", "3D bounding boxes †", "Project down"
VOXELS, VOXELS_PLUS = "Voxel floor (SSCNet) †", "Voxel floor, objects down (SSCNet+) †"
VISIBLE, RANSAC, ORACLE = "Visible ground", "RANSAC plane", "RANSAC (oracle) ‡"

BASELINES = (
    *(NOTHING, EVERYTHING, HULL, BOXES, VOXELS, VOXELS_PLUS, PROJECT_DOWN, VISIBLE, RANSAC, ORACLE),
)
"""All baselines, in the order of the tables."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """What a method predicts for an image; None for maps it does not have. All maps are (H, W).

    Attributes:
        ground: the paper's S*.
        ground_depth_m: the paper's D*, metres, also where there is no ground.
        visible_ground: the paper's S.
        visible_depth_m: the paper's D, metres.
        ground_probability: the paper's S* before the threshold.
    """

    ground: Mask | None = None
    ground_depth_m: Floats | None = None
    visible_ground: Mask | None = None
    visible_depth_m: Floats | None = None
    ground_probability: Floats | None = None


def estimate_of(prediction: Prediction, size: Size) -> Estimate:
    """The estimate of a model, at the size (H, W) of the ground truth."""
    at_size = prediction.at_size(size)
    return Estimate(
        at_size.ground,
        at_size.unmasked_ground_depth_m,
        at_size.visible_ground,
        at_size.visible_depth_m,
        at_size.ground_probability,
    )


def baselines(
    prediction: Prediction,
    ground_truth: GroundTruth,
    name: str,
    boxes: tuple[Box, ...] | None,
    voxels: VoxelGrid | None,
) -> Iterator[tuple[str, Estimate]]:
    """Every baseline that can be computed for an image, with the name of its row.

    Args:
        prediction: prediction of the first model, at its own size.
        ground_truth: the ground truth of the image.
        name: name of the image; it seeds random baselines.
        boxes: objects in the image, if known.
        voxels: the scene in voxels, if known.
    """
    at_size = prediction.at_size(ground_truth.size)
    camera, visible = at_size.intrinsics, at_size.visible_ground
    seed = zlib.crc32(name.encode())
    hull = convex_hull(visible)
    yield NOTHING, Estimate(np.zeros(ground_truth.size, bool))
    yield EVERYTHING, Estimate(np.ones(ground_truth.size, bool))
    yield HULL, Estimate(hull)
    if boxes is not None:
        yield BOXES, Estimate(without_footprints(hull, boxes, camera))
    if voxels is not None:
        depth_m, clear = voxels.floor(camera, ground_truth.size)
        yield VOXELS, Estimate(np.isfinite(depth_m), depth_m)
        yield VOXELS_PLUS, Estimate(clear)
    yield PROJECT_DOWN, Estimate(hull & ~projected_down(prediction, ground_truth.size, seed))
    yield VISIBLE, Estimate(visible)
    plane_depth_m = ransac_depth_m(
        prediction.visible_depth_m,
        prediction.visible_ground,
        prediction.intrinsics,
        ground_truth.size,
        seed,
    )
    if plane_depth_m is not None:
        yield RANSAC, Estimate(ground_depth_m=plane_depth_m)
    if ground_truth.visible_ground is not None and ground_truth.visible_depth_m is not None:
        plane_depth_m = ransac_depth_m(
            ground_truth.visible_depth_m,
            ground_truth.visible_ground.mask,
            camera,
            ground_truth.size,
            seed,
        )
        if plane_depth_m is not None:
            yield ORACLE, Estimate(ground_depth_m=plane_depth_m)


def without_footprints(ground: Mask, boxes: tuple[Box, ...], intrinsics: Intrinsics) -> Mask:
    """Ground (H, W) without the footprints of boxes: the paper's "3D bounding boxes"."""
    left = ground.copy()
    for box in boxes:
        left &= ~box.footprint(intrinsics, (ground.shape[0], ground.shape[1]))
    return left


def projected_down(prediction: Prediction, size: Size, seed: int) -> Mask:
    """Footprint mask (H, W) from the visible depth alone: "Project down".

    The paper makes such masks from depth ("depth masking") and trains a classifier on them. Here
    the same construction runs on the model's own predicted depth, at the network's size. Large
    regions are dropped, as they are from training labels.
    """
    from PIL import Image

    from footprints_edge_models.video_labels.footprint_masks import (
        drop_large_regions,
        footprint_pixels,
    )

    standing = footprint_pixels(
        prediction.visible_depth_m,
        prediction.visible_ground_probability,
        prediction.intrinsics,
        seed,
    )
    mask = Image.fromarray(drop_large_regions(standing))
    return np.asarray(mask.resize((size[1], size[0]), Image.Resampling.NEAREST))


def ransac_depth_m(
    depth_m: Floats, ground: Mask, intrinsics: Intrinsics, size: Size, seed: int
) -> Floats | None:
    """Depth at which each ray meets the plane through the ground pixels: "RANSAC plane".

    Args:
        depth_m: float32 (h, w), metres, 0 where unknown.
        ground: bool (h, w), the pixels to fit the plane to.
        intrinsics: the camera in pixels of (h, w).
        size: (H, W) of the result.
        seed: seed of the fit.

    Returns:
        float32 (H, W), metres, infinite where a ray never meets it; None if no plane can be
        fitted.
    """
    from footprints_edge_models.mapping.planes import fit_plane

    from_size = (depth_m.shape[0], depth_m.shape[1])
    points = backproject(depth_m, intrinsics)[ground & (depth_m > 0)]
    plane = fit_plane(points, np.random.default_rng(seed))
    if plane is None:
        return None
    return plane.depth_m(rays(intrinsics.scaled(from_size, size), size)).astype(np.float32)
