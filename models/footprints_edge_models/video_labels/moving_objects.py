"""Masks of moving objects (paper, section "Masking moving objects").

Depth and the camera's motion give the flow of a static pixel (induced flow); optical flow gives the
actual one. Where the two differ by more than tau, something moved.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics, backproject

TAU_PX = 3.0

LEAST_GAIN = 5.0
"""Grey levels, out of 255, by which optical flow must explain the other image better."""
MOST_MOVING = 0.5
"""Where more than this share of an image seems to move, its pose or depth is wrong."""


def induced_flow_px(
    depth_m: NDArray[np.float32],
    source: Intrinsics,
    target: Intrinsics,
    source_to_target: NDArray[np.floating],
) -> NDArray[np.float32]:
    """The flow of every pixel if nothing but the camera moves.

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
        start_px: float32 (H, W, 2), initial flow, NaN for none. The induced flow lets the search
            follow fast cameras.

    Returns:
        float32 (H, W, 2), pixels along x and y.
    """
    grey = [cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY) for picture in (image, other)]
    search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    flow: NDArray[np.float32] = search.calc(grey[0], grey[1], np.nan_to_num(start_px))
    return flow


def is_consistent(
    forward_px: NDArray[np.float32], backward_px: NDArray[np.float32]
) -> NDArray[np.bool_]:
    """The forward-backward check of optical flow: forward and back again ends where it began.

    Args:
        forward_px: float32 (H, W, 2), from one image to another.
        backward_px: float32 (H, W, 2), from the other image back.

    Returns:
        bool (H, W), within half of ``TAU_PX``.
    """
    height, width = forward_px.shape[:2]
    x = forward_px[..., 0] + np.arange(width, dtype=np.float32)
    y = forward_px[..., 1] + np.arange(height, dtype=np.float32)[:, None]
    back_px = cv2.remap(backward_px, x, y, cv2.INTER_LINEAR)
    consistent: NDArray[np.bool_] = np.linalg.norm(forward_px + back_px, axis=-1) < TAU_PX / 2
    return consistent


def flow_explains_better(
    image: NDArray[np.uint8],
    other: NDArray[np.uint8],
    induced_px: NDArray[np.float32],
    optical_px: NDArray[np.float32],
) -> NDArray[np.bool_]:
    """Where optical flow has a lower photometric error than the induced flow.

    On plain walls and in blur, optical flow drifts in both directions and passes the
    forward-backward check; but there the induced flow has as low an error.

    Args:
        image: uint8 (H, W, 3), RGB.
        other: uint8 (H, W, 3), RGB.
        induced_px: float32 (H, W, 2), NaN where unknown.
        optical_px: float32 (H, W, 2).

    Returns:
        bool (H, W): lower by more than ``LEAST_GAIN`` grey levels, averaged around a pixel.
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


def checked_flow_px(
    image: NDArray[np.uint8],
    other: NDArray[np.uint8],
    induced_px: NDArray[np.float32],
    returning_px: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Optical flow after a forward-backward check and a photometric check.

    Args:
        image: uint8 (H, W, 3), RGB.
        other: uint8 (H, W, 3), RGB.
        induced_px: float32 (H, W, 2), from the picture to the other, NaN where unknown.
        returning_px: float32 (H, W, 2), induced from the other to the picture.

    Returns:
        float32 (H, W, 2): the induced flow where its photometric error is as low, NaN where the
        forward-backward check fails.
    """
    forward_px = optical_flow_px(image, other, induced_px)
    backward_px = optical_flow_px(other, image, returning_px)
    flow_px = forward_px.copy()
    flow_px[~is_consistent(forward_px, backward_px)] = np.nan
    if not moving_pixels(induced_px, flow_px).any():  # nothing does, or the pose is wrong
        return flow_px
    explained = ~flow_explains_better(image, other, induced_px, forward_px) & np.isfinite(
        flow_px[..., 0]
    )
    flow_px[explained] = induced_px[explained]
    return flow_px


def moving_pixels(
    induced_px: NDArray[np.float32], optical_px: NDArray[np.float32]
) -> NDArray[np.bool_]:
    """Where induced and optical flow differ by more than ``TAU_PX``.

    Args:
        induced_px: float32 (H, W, 2), NaN where unknown.
        optical_px: float32 (H, W, 2), NaN where it failed its checks.

    Returns:
        bool (H, W). False where either flow is unknown, and where a pixel leaves the image. All
        False where more than ``MOST_MOVING`` of the other pixels differ.
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
