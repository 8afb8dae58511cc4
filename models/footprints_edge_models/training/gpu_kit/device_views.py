"""Batches cut out of stored views on the device, many views at once, no copy to the host.

What ``data.augmentation`` does, by nothing but indexing and arithmetic in float32: it runs alike on
a CPU and on a GPU.
"""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from footprints_edge_models.data.targets import FOOTPRINT_WEIGHT, LAMBDA, UNLIKELY_WEIGHT, Targets
from footprints_edge_models.networks.channels import MAX_DEPTH_M, MIN_DEPTH_M
from footprints_edge_models.sample import FOOTPRINT, NO, UNKNOWN, UNLIKELY, UNSEEN, YES
from footprints_edge_models.training.gpu_kit.device_store import StoredBatch
from footprints_edge_models.training.gpu_kit.stored_view import (
    GROUND_CODES,
    GROUND_MASK,
    GROUND_SHIFT,
    MOVING_BIT,
    VISIBLE_CODES,
    VISIBLE_MASK,
)

DeviceBatch = tuple[torch.Tensor, Targets]
"""RGB float32 (B, 3, h, w) in [0, 1], and its targets, on one device."""

_OUTSIDE = VISIBLE_CODES.index(UNKNOWN) | GROUND_CODES.index(UNKNOWN) << GROUND_SHIFT
_SHARPER = 1.25
"""Views shrunk by more than this are sampled twice along each side."""


@dataclass(frozen=True)
class VirtualCameras:
    """Virtual cameras, one a view; see :class:`augmentation.VirtualCamera`. On the host.

    Attributes:
        homography: float64 (B, 3, 3), from pixels of the cut view to those of the stored one.
        depth: float64 (B, 3): a stored depth is divided by this times (x, y, 1).
        flip: bool (B,).
        shrinks: Most stored pixels to a pixel of a cut view, along a side.
    """

    homography: NDArray[np.float64]
    depth: NDArray[np.float64]
    flip: NDArray[np.bool_]
    shrinks: float


def draw_cameras(
    sizes: NDArray[np.int64],
    intrinsics: NDArray[np.float64],
    size: tuple[int, int],
    focal_px: float,
    rng: np.random.Generator | None,
) -> VirtualCameras:
    """As :func:`augmentation.draw_virtual_camera` draws them; central views without ``rng``.

    Args:
        sizes: (B, 2), (H, W) of the stored views.
        intrinsics: (B, 4), fx, fy, cx, cy.
        size: (h, w) of the cut views.
        focal_px: Of the canonical camera.
        rng: Draws them.
    """
    count = len(sizes)
    zoom, at, roll, flip = np.ones(count), np.full((count, 2), 0.5), np.zeros(count), None
    if rng is not None:
        zoom = 1 + 0.7 * rng.random(count) ** 2
        at = rng.random((count, 2))
        roll = rng.normal(0, np.radians(3), count)
        flip = rng.random(count) < 0.5
    fx, fy, cx, cy = intrinsics.T
    scale = zoom * (np.array(size) / sizes).max(axis=1)
    window = np.array([size[1], size[0]]) / scale[:, None]
    centre = window / 2 + (sizes[:, ::-1] - window) * at - 0.5
    axis = np.stack([(centre[:, 0] - cx) / fx, (centre[:, 1] - cy) / fy, np.ones(count)], axis=1)
    forward = axis / np.linalg.norm(axis, axis=1, keepdims=True)
    right = np.cross([0, 1, 0], forward)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    upright = np.stack([right, np.cross(forward, right), forward], axis=1)
    cos, sin, none, one = np.cos(roll), np.sin(roll), np.zeros(count), np.ones(count)
    turn = np.stack([cos, -sin, none, sin, cos, none, none, none, one], axis=1)
    rotation = turn.reshape(-1, 3, 3) @ upright
    focal = np.sqrt(fx * fy) * scale
    middle_x, middle_y = (size[1] - 1) / 2, (size[0] - 1) / 2
    source = np.stack([fx, none, cx, none, fy, cy, none, none, one], axis=1).reshape(-1, 3, 3)
    inverse = np.stack(
        [1 / focal, none, -middle_x / focal, none, 1 / focal, -middle_y / focal, none, none, one],
        axis=1,
    ).reshape(-1, 3, 3)
    to_ray = rotation.transpose(0, 2, 1) @ inverse
    return VirtualCameras(
        source @ to_ray,
        to_ray[:, 2] * (focal / focal_px)[:, None],
        np.zeros(count, bool) if flip is None else flip,
        float((1 / scale).max()),
    )


def cut_views(stored: StoredBatch, cameras: VirtualCameras, size: tuple[int, int]) -> DeviceBatch:
    """What virtual cameras see of stored views: pictures (B, 3, h, w) in [0, 1], and targets.

    Pictures are sampled bilinearly, mirrored at their edges; labels and depths by the nearest
    pixel, unknown outside.
    """
    device = stored.pixels.device
    count, (height, width) = len(stored.sizes), size

    numbers = np.concatenate(
        [
            cameras.homography.reshape(-1, 9),
            cameras.depth,
            cameras.flip[:, None],
            stored.sizes[:, ::-1] - 1,
        ],
        axis=1,
    ).astype(np.float32)
    # not blocking: else the host would wait here for all that the GPU still has to do
    facts = torch.from_numpy(numbers).to(device, non_blocking=True).reshape(count, -1, 1, 1)
    flip, most_x, most_y = facts[:, 12], facts[:, 13], facts[:, 14]  # (B, 1, 1)
    columns = torch.arange(width, dtype=torch.float32, device=device).reshape(1, 1, width)
    x = columns + flip * (width - 1 - 2 * columns)  # (B, 1, w)
    y = torch.arange(height, dtype=torch.float32, device=device).reshape(1, height, 1)

    def places(right: float, down: float) -> tuple[torch.Tensor, torch.Tensor]:
        """Where the stored views are seen, (B, h, w) each."""
        u, v = x + right, y + down
        depth = facts[:, 6] * u + facts[:, 7] * v + facts[:, 8]
        depth = depth.clamp(min=1e-3)
        return (
            (facts[:, 0] * u + facts[:, 1] * v + facts[:, 2]) / depth,
            (facts[:, 3] * u + facts[:, 4] * v + facts[:, 5]) / depth,
        )

    def at(memory: torch.Tensor, column: torch.Tensor, row: torch.Tensor) -> torch.Tensor:
        index = (row * (most_x + 1) + column).long().reshape(count, -1)
        return memory.gather(1, index)  # (B, h w)

    repeats = 2 if cameras.shrinks > _SHARPER else 1
    offsets = [(k + 0.5) / repeats - 0.5 for k in range(repeats)]
    image = torch.zeros((count, height * width, 3), device=device)
    for right in offsets:
        for down in offsets:
            column, row = places(right, down)
            left, top = column.floor(), row.floor()
            for dx in (0, 1):
                for dy in (0, 1):
                    weight = (1 - dx + (2 * dx - 1) * (column - left)) * (
                        1 - dy + (2 * dy - 1) * (row - top)
                    )
                    tap = at(
                        stored.pixels, _mirrored(left + dx, most_x), _mirrored(top + dy, most_y)
                    )
                    rgb = tap.view(torch.uint8).reshape(count, -1, 4)[..., :3]
                    image.addcmul_(rgb.float(), weight.reshape(count, -1, 1))
    image /= 255 * repeats * repeats

    column, row = (place.round() for place in places(0.0, 0.0))
    inside = (column >= 0) & (column <= most_x) & (row >= 0) & (row <= most_y)
    column, row = column.clamp(min=0).minimum(most_x), row.clamp(min=0).minimum(most_y)
    labels = at(stored.pixels, column, row).view(torch.uint8).reshape(count, height, width, 4)
    label = torch.where(inside, labels[..., 3], _OUTSIDE)
    depths_m = at(stored.depths_m, column, row).view(torch.float16)
    depths_m = depths_m.reshape(count, height, width, 2).float()
    depths_m = depths_m / (facts[:, 9] * x + facts[:, 10] * y + facts[:, 11])[..., None]
    known = inside[..., None] & (depths_m > MIN_DEPTH_M) & (depths_m < MAX_DEPTH_M)
    depths_m = torch.where(known, depths_m, 0)
    targets = _targets(label, depths_m)
    return image.reshape(count, height, width, 3).permute(0, 3, 1, 2), targets


def _mirrored(place: torch.Tensor, most: torch.Tensor) -> torch.Tensor:
    """Places along a side, whole numbers, mirrored into [0, most]; an edge is not repeated."""
    period = 2 * most
    return most - (most - place.remainder(period)).abs()


def _targets(label: torch.Tensor, depths_m: torch.Tensor) -> Targets:
    """The targets that :func:`augmentation.render_view` makes of the same labels."""
    visible = label & VISIBLE_MASK
    ground = label >> GROUND_SHIFT & GROUND_MASK

    def is_ground(value: int) -> torch.Tensor:
        return (ground == GROUND_CODES.index(value)).float()

    return Targets(
        visible_ground=(visible == VISIBLE_CODES.index(YES)).float(),
        visible_ground_valid=(visible != VISIBLE_CODES.index(UNKNOWN)).float(),
        ground=is_ground(YES),
        ground_weight=is_ground(YES),
        untraversable=is_ground(NO) + FOOTPRINT_WEIGHT * is_ground(FOOTPRINT),
        unknown_weight=LAMBDA * is_ground(UNSEEN) + UNLIKELY_WEIGHT * is_ground(UNLIKELY),
        moving=(label & MOVING_BIT > 0).float(),
        visible_depth_m=depths_m[..., 0],
        ground_depth_m=depths_m[..., 1],
    )
