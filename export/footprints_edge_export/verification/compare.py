"""Differences between the maps of two models, on photos."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import disparity_to_depth
from footprints_edge.model import Model
from footprints_edge.model_files.metadata import OUTPUTS
from footprints_edge_export.errors import ExportError

CHANNELS = ("visible_ground", "ground", "visible_depth", "ground_depth")


@dataclass(frozen=True)
class Difference:
    """Model B against model A, over all photos together.

    Attributes:
        photos: number of photos.
        max_abs: largest difference of each of the four maps.
        visible_ground_iou: IoU of the masks at probability 0.5; 1 if both are empty.
        ground_iou: likewise.
        visible_depth_abs_rel: mean |d_b - d_a| / d_a.
        visible_depth_a1: share of pixels whose depths are within a factor of 1.25.
        ground_depth_abs_rel: the same, where A sees ground; NaN where it sees none.
        ground_depth_a1: likewise.
    """

    photos: int
    max_abs: dict[str, float]
    visible_ground_iou: float
    ground_iou: float
    visible_depth_abs_rel: float
    visible_depth_a1: float
    ground_depth_abs_rel: float
    ground_depth_a1: float

    def as_dict(self) -> dict[str, object]:
        """For JSON: NaN becomes None."""
        return {k: None if v != v else v for k, v in asdict(self).items()}  # noqa: PLR0124


def compare_maps(
    pairs: Iterable[tuple[NDArray[np.float32], NDArray[np.float32]]],
    ranges_m: tuple[tuple[float, float], tuple[float, float]] = ((0.1, 100), (0.1, 100)),
) -> Difference:
    """Difference of pairs of maps (1, 4, H, W), A first.

    Args:
        pairs: one pair a photo.
        ranges_m: depth range (nearest, farthest) of A and of B.
    """
    photos = 0
    max_abs = np.zeros(4)
    overlap, union = np.zeros(2), np.zeros(2)
    errors, near, counts = np.zeros(2), np.zeros(2), np.zeros(2)
    for a, b in pairs:
        photos += 1
        max_abs = np.maximum(max_abs, np.abs(a - b).max(axis=(0, 2, 3)))
        masks_a, masks_b = a[0, :2] > 0.5, b[0, :2] > 0.5
        overlap += (masks_a & masks_b).sum(axis=(1, 2))
        union += (masks_a | masks_b).sum(axis=(1, 2))
        depth_a = disparity_to_depth(a[0, 2:], *ranges_m[0])
        ratio = disparity_to_depth(b[0, 2:], *ranges_m[1]) / depth_a
        for i, where in enumerate((np.ones_like(masks_a[0]), masks_a[1])):
            errors[i] += np.abs(ratio[i][where] - 1).sum()
            near[i] += (np.maximum(ratio[i][where], 1 / ratio[i][where]) < 1.25).sum()
            counts[i] += where.sum()
    with np.errstate(invalid="ignore", divide="ignore"):
        iou = np.where(union > 0, overlap / union, 1.0)
        abs_rel, a1 = errors / counts, near / counts
    return Difference(
        photos=photos,
        max_abs=dict(zip(CHANNELS, max_abs.tolist(), strict=True)),
        visible_ground_iou=float(iou[0]),
        ground_iou=float(iou[1]),
        visible_depth_abs_rel=float(abs_rel[0]),
        visible_depth_a1=float(a1[0]),
        ground_depth_abs_rel=float(abs_rel[1]),
        ground_depth_a1=float(a1[1]),
    )


def compare_models(model_a: Model, model_b: Model, images: list[NDArray[np.uint8]]) -> Difference:
    """Difference of two models on preprocessed photos, uint8 (1, H, W, 3) each.

    Maps that neither model has count as equal, and as ground everywhere.

    Raises:
        ExportError: they have different maps.
    """
    outputs = model_a.metadata.outputs
    if model_b.metadata.outputs != outputs:
        raise ExportError(
            f"the first model has {outputs} maps, the second {model_b.metadata.outputs}"
        )
    pairs = (
        (
            all_four(model_a.engine.run(image), outputs),
            all_four(model_b.engine.run(image), outputs),
        )
        for image in images
    )
    ranges_m = (model_a.metadata.depth_range_m, model_b.metadata.depth_range_m)
    return compare_maps(pairs, ranges_m)


def all_four(maps: NDArray[np.float32], outputs: str) -> NDArray[np.float32]:
    """All four maps (1, 4, H, W); those that a file lacks are 1.

    Args:
        maps: float32 (1, C, H, W).
        outputs: which maps these are, a key of ``footprints_edge.model_files.metadata.OUTPUTS``.
    """
    four = np.ones((1, 4, *maps.shape[2:]), np.float32)
    four[:, list(OUTPUTS[outputs])] = maps
    return four
