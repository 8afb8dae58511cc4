"""Augmentation by a virtual camera: a sample as another camera would see it.

Crop, zoom, flip and roll are one operation: a virtual camera at the same place looks in a random
direction with a random focal length. Its image is a homography of the original, and its depth
follows exactly, so metric depth survives every augmentation. Depths are converted to the canonical
camera at the end.
"""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics, rays
from footprints_edge.inputs.preprocessing import resized
from footprints_edge_models.data.degradation import degraded
from footprints_edge_models.data.targets import FOOTPRINT_WEIGHT, LAMBDA, UNLIKELY_WEIGHT
from footprints_edge_models.networks.channels import MAX_DEPTH_M, MIN_DEPTH_M
from footprints_edge_models.networks.edge import FOCAL_PX
from footprints_edge_models.sample import FOOTPRINT, NO, UNKNOWN, UNLIKELY, UNSEEN, YES, Sample


@dataclass(frozen=True)
class VirtualView:
    """A virtual camera's image, uint8 (h, w, 3), and its targets, float32 (h, w).

    The fields after ``image`` are those of :class:`targets.Targets`; depths are canonical.
    """

    image: NDArray[np.uint8]
    visible_ground: NDArray[np.float32]
    visible_ground_valid: NDArray[np.float32]
    ground: NDArray[np.float32]
    ground_weight: NDArray[np.float32]
    untraversable: NDArray[np.float32]
    unknown_weight: NDArray[np.float32]
    moving: NDArray[np.float32]
    visible_depth_m: NDArray[np.float32]
    ground_depth_m: NDArray[np.float32]


@dataclass(frozen=True)
class VirtualCamera:
    """A virtual camera at the place of the original one.

    Attributes:
        intrinsics: in pixels of the view.
        rotation: (3, 3), from the original camera's axes to the view's.
        flip: mirror the view left to right.
    """

    intrinsics: Intrinsics
    rotation: NDArray[np.float64]
    flip: bool


def draw_virtual_camera(
    sample: Sample, size: tuple[int, int], rng: np.random.Generator | None
) -> VirtualCamera:
    """A camera whose view lies within the sample, but for corners; central without ``rng``.

    Zoom is up to 1.7, wide views more often; roll has a deviation of 3 degrees. A camera that looks
    aside sees a trapezoid of the image: the outside is mirrored and has no labels.
    """
    height, width = sample.image.shape[:2]
    camera = sample.intrinsics
    zoom = 1.0 if rng is None else 1 + 0.7 * rng.random() ** 2
    scale = zoom * max(size[0] / height, size[1] / width)
    window = np.array([size[1], size[0]]) / scale
    slack = np.array([width, height]) - window
    centre = window / 2 + slack * (0.5 if rng is None else rng.random(2)) - 0.5
    axis = np.array([(centre[0] - camera.cx) / camera.fx, (centre[1] - camera.cy) / camera.fy, 1])
    forward = axis / np.linalg.norm(axis)
    right = np.cross([0, 1, 0], forward)
    right /= np.linalg.norm(right)
    upright = np.stack([right, np.cross(forward, right), forward])
    roll = 0.0 if rng is None else rng.normal(0, np.radians(3))
    cos, sin = np.cos(roll), np.sin(roll)
    rolled = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]]) @ upright
    focal_px = camera.focal_px * scale
    middle = ((size[1] - 1) / 2, (size[0] - 1) / 2)
    intrinsics = Intrinsics(focal_px, focal_px, *middle)
    return VirtualCamera(intrinsics, rolled, rng is not None and rng.random() < 0.5)


def render_view(
    sample: Sample,
    size: tuple[int, int],
    rng: np.random.Generator | None = None,
    focal_px: float = FOCAL_PX,
) -> VirtualView:
    """The view of a random virtual camera, with colour jitter; central and plain without ``rng``.

    Args:
        sample: the sample to augment.
        size: (h, w) of the view.
        rng: draws the camera and the colours; None gives the central view.
        focal_px: focal length of the canonical camera.
    """
    view = draw_virtual_camera(sample, size, rng)
    target, source = view.intrinsics, sample.intrinsics
    homography = source.matrix @ view.rotation.T @ np.linalg.inv(target.matrix)

    def warp(array: NDArray[Any], outside: float) -> NDArray[Any]:
        warped: NDArray[Any] = cv2.warpPerspective(
            array,
            homography,
            size[::-1],
            flags=cv2.WARP_INVERSE_MAP | cv2.INTER_NEAREST,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=outside,
        )
        return warped[:, ::-1] if view.flip else warped

    # depth' = depth / w_z, with w the view's ray turned into the original camera (z' = 1)
    turned_z = rays(target, size) @ view.rotation[:, 2]
    to_canonical = focal_px / target.focal_px / (turned_z[:, ::-1] if view.flip else turned_z)

    def canonical(depth_m: NDArray[np.float16] | None) -> NDArray[np.float32]:
        if depth_m is None:
            return np.zeros(size, np.float32)
        depth = warp(depth_m.astype(np.float32), outside=0) * to_canonical
        return np.where((depth > MIN_DEPTH_M) & (depth < MAX_DEPTH_M), depth, 0).astype(np.float32)

    image = take_picture(sample, view, size)
    visible = warp(sample.visible_ground, outside=UNKNOWN)
    moving = np.zeros(size, np.uint8)
    if sample.moving is not None:
        moving = warp(sample.moving, outside=0)
    ground = warp(sample.ground, outside=UNKNOWN)
    return VirtualView(
        image if rng is None else degraded(jitter_colours(image, rng), rng),
        (visible == YES).astype(np.float32),
        (visible != UNKNOWN).astype(np.float32),
        (ground == YES).astype(np.float32),
        (ground == YES).astype(np.float32),
        (ground == NO).astype(np.float32) + FOOTPRINT_WEIGHT * (ground == FOOTPRINT),
        LAMBDA * (ground == UNSEEN).astype(np.float32) + UNLIKELY_WEIGHT * (ground == UNLIKELY),
        moving.astype(np.float32),
        canonical(sample.visible_depth_m),
        canonical(sample.ground_depth_m),
    )


def take_picture(sample: Sample, view: VirtualCamera, size: tuple[int, int]) -> NDArray[np.uint8]:
    """The picture of a virtual camera, uint8 (h, w, 3); outside the sample it is mirrored.

    The camera has the pixels of the sample's own, and its picture is shrunk as the runtime shrinks
    pictures: by the same filter, antialiased.
    """
    shrinks = max(1.0, sample.intrinsics.focal_px / view.intrinsics.focal_px)
    own = (round(shrinks * size[0]), round(shrinks * size[1]))
    homography = (
        sample.intrinsics.matrix
        @ view.rotation.T
        @ np.linalg.inv(view.intrinsics.scaled(size, own).matrix)
    )
    picture = np.asarray(
        cv2.warpPerspective(
            sample.image,
            homography,
            own[::-1],
            flags=cv2.WARP_INVERSE_MAP | cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REFLECT_101,
        ),
        np.uint8,
    )
    image = picture if own == size else resized(picture, size)
    return image[:, ::-1] if view.flip else image


def jitter_colours(image: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """Colour jitter: brightness, contrast, gamma, saturation, hue, greyscale."""
    values = np.arange(256) / 255
    values = values ** np.exp(rng.normal(0, 0.25))
    values = (values - 0.5) * (1 + rng.normal(0, 0.2)) + 0.5 + rng.normal(0, 0.08)
    image = cv2.LUT(image, np.clip(values * 255, 0, 255).astype(np.uint8))
    if rng.random() < 0.12:
        image = cv2.cvtColor(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), cv2.COLOR_GRAY2RGB)
    elif rng.random() < 0.6:
        hsv = cv2.cvtColor(image, cv2.COLOR_RGB2HSV)
        saturation = np.clip(np.arange(256) * (1 + rng.normal(0, 0.25)), 0, 255).astype(np.uint8)
        turn = round(rng.normal(0, 6))  # OpenCV's hue runs from 0 to 179
        hue = ((np.arange(256) + turn) % 180).astype(np.uint8)
        table = np.stack([hue, saturation, np.arange(256, dtype=np.uint8)], axis=-1)[None]
        image = cv2.cvtColor(cv2.LUT(hsv, table), cv2.COLOR_HSV2RGB)
    return np.ascontiguousarray(image)
