"""Pixels of things that move by themselves (paper, section "Masking moving objects").

The camera's own motion and the depth say where a standing pixel would go (induced flow); optical
flow says where it went. Where the two ends lie more than tau apart, something moved.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics, backproject

TAU_PX = 3.0

LEAST_GAIN = 5.0
"""Grey levels, of 255."""
MOST_MOVING = 0.5
"""Where more than this share of a picture seems to move, its pose or depth is wrong instead."""


def induced_flow_px(
    depth_m: NDArray[np.float32],
    source: Intrinsics,
    target: Intrinsics,
    source_to_target: NDArray[np.floating],
) -> NDArray[np.float32]:
    """How far every pixel moves in the picture if nothing but the camera does.

    Args:
        depth_m: float32 (H, W), metres along the optical axis, 0 where unknown.
        source: the camera of ``depth_m``.
        target: the camera after the motion, in pixels of a picture of the same size.
        source_to_target: (4, 4), from the source camera's axes to the target's.

    Returns:
        float32 (H, W, 2), pixels along x and y; NaN where the depth is unknown or the point lies
        behind the target camera.
    """
    height, width = depth_m.shape
    points = backproject(depth_m, source) @ source_to_target[:3, :3].T + source_to_target[:3, 3]
    depth = points[..., 2]
    seen = (depth_m > 0) & (depth > 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        x = target.fx * points[..., 0] / depth + target.cx - np.arange(width)
        y = target.fy * points[..., 1] / depth + target.cy - np.arange(height)[:, None]
    return np.where(seen[..., None], np.stack([x, y], axis=-1), np.nan).astype(np.float32)


def optical_flow_px(
    image: NDArray[np.uint8], other: NDArray[np.uint8], start_px: NDArray[np.float32]
) -> NDArray[np.float32]:
    """OpenCV's dense inverse search from one picture to another.

    Args:
        image: uint8 (H, W, 3), RGB.
        other: uint8 (H, W, 3), RGB.
        start_px: float32 (H, W, 2), where the search begins, NaN for nowhere in particular. With
            the induced flow, fast cameras are followed, and what stands still is soon found.

    Returns:
        float32 (H, W, 2), pixels along x and y.
    """
    grey = [cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY) for picture in (image, other)]
    search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    flow: NDArray[np.float32] = search.calc(grey[0], grey[1], np.nan_to_num(start_px))
    return flow


def there_and_back(
    forward_px: NDArray[np.float32], backward_px: NDArray[np.float32]
) -> NDArray[np.bool_]:
    """Where optical flow may be believed: forward and back again ends where it began.

    Args:
        forward_px: float32 (H, W, 2), from one picture to another.
        backward_px: float32 (H, W, 2), from the other to the one.

    Returns:
        bool (H, W), within half of ``TAU_PX``.
    """
    height, width = forward_px.shape[:2]
    x = forward_px[..., 0] + np.arange(width, dtype=np.float32)
    y = forward_px[..., 1] + np.arange(height, dtype=np.float32)[:, None]
    back_px = cv2.remap(backward_px, x, y, cv2.INTER_LINEAR)
    believed: NDArray[np.bool_] = np.linalg.norm(forward_px + back_px, axis=-1) < TAU_PX / 2
    return believed


def needs_motion(
    image: NDArray[np.uint8],
    other: NDArray[np.uint8],
    induced_px: NDArray[np.float32],
    optical_px: NDArray[np.float32],
) -> NDArray[np.bool_]:
    """Where optical flow explains the other picture better than standing still does.

    On plain walls and in blur optical flow drifts, forward and back alike; but there the colours
    at the end of the induced flow fit as well.

    Args:
        image: uint8 (H, W, 3), RGB.
        other: uint8 (H, W, 3), RGB.
        induced_px: float32 (H, W, 2), NaN where unknown.
        optical_px: float32 (H, W, 2).

    Returns:
        bool (H, W): by more than ``LEAST_GAIN`` grey levels on average around a pixel.
    """
    grey, other_grey = (
        cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY).astype(np.float32) for picture in (image, other)
    )
    height, width = grey.shape
    columns = np.arange(width, dtype=np.float32)
    rows = np.arange(height, dtype=np.float32)[:, None]

    def misfit(flow_px: NDArray[np.float32]) -> NDArray[np.float32]:
        flow_px = np.nan_to_num(flow_px)
        x, y = columns + flow_px[..., 0], rows + flow_px[..., 1]
        found = cv2.remap(other_grey, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        around: NDArray[np.float32] = cv2.blur(np.abs(grey - found), (7, 7))
        return around

    return misfit(induced_px) > misfit(optical_px) + LEAST_GAIN


def believed_flow_px(
    image: NDArray[np.uint8],
    other: NDArray[np.uint8],
    induced_px: NDArray[np.float32],
    returning_px: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Optical flow as far as it may contradict the induced flow.

    Args:
        image: uint8 (H, W, 3), RGB.
        other: uint8 (H, W, 3), RGB.
        induced_px: float32 (H, W, 2), from the picture to the other, NaN where unknown.
        returning_px: float32 (H, W, 2), induced from the other to the picture.

    Returns:
        float32 (H, W, 2): the induced flow where that explains the pictures as well, NaN where
        optical flow does not lead back.
    """
    forward_px = optical_flow_px(image, other, induced_px)
    backward_px = optical_flow_px(other, image, returning_px)
    flow_px = forward_px.copy()
    flow_px[~there_and_back(forward_px, backward_px)] = np.nan
    if not moving_pixels(induced_px, flow_px).any():  # nothing does, or the pose is wrong
        return flow_px
    explained = ~needs_motion(image, other, induced_px, forward_px) & np.isfinite(flow_px[..., 0])
    flow_px[explained] = induced_px[explained]
    return flow_px


def moving_pixels(
    induced_px: NDArray[np.float32], optical_px: NDArray[np.float32]
) -> NDArray[np.bool_]:
    """Where induced and optical flow end more than ``TAU_PX`` apart.

    Args:
        induced_px: float32 (H, W, 2), NaN where unknown.
        optical_px: float32 (H, W, 2), NaN where not to be believed.

    Returns:
        bool (H, W). Not called moving are pixels of which either flow is unknown, and those that
        leave the picture, where optical flow has nothing to hold on to. All False where more than
        ``MOST_MOVING`` of the others disagree.
    """
    height, width = induced_px.shape[:2]
    x = induced_px[..., 0] + np.arange(width)
    y = induced_px[..., 1] + np.arange(height)[:, None]
    judged = (x >= 0) & (x <= width - 1) & (y >= 0) & (y <= height - 1)  # False where NaN
    judged &= np.isfinite(optical_px).all(axis=-1)
    apart_px = np.linalg.norm(induced_px - optical_px, axis=-1)
    moving: NDArray[np.bool_] = judged & (apart_px > TAU_PX)
    if moving.sum() > MOST_MOVING * judged.sum():
        return np.zeros_like(moving)
    return moving
