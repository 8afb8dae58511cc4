"""What a camera does to a picture: blur, motion blur, noise, JPEG."""

import cv2
import numpy as np
from numpy.typing import NDArray

BLURRED, SHAKEN, NOISY, COMPRESSED = 0.15, 0.1, 0.2, 0.25
"""Shares of pictures that are out of focus, blurred by motion, noisy, and saved as JPEG."""
JPEG_QUALITY = (35, 92)
LONGEST_MOTION = 0.02
"""Length of motion blur, as a share of the longer side."""


def degraded(image: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """The picture, uint8 (H, W, 3), as a worse camera would have taken it; often unchanged."""
    if rng.random() < BLURRED:
        image = _uint8(cv2.GaussianBlur(image, (0, 0), rng.uniform(0.5, 1.2)))
    if rng.random() < SHAKEN:
        length_px = rng.uniform(2, max(3, LONGEST_MOTION * max(image.shape)))
        kernel = motion_kernel(length_px, rng.uniform(0, np.pi))
        image = _uint8(cv2.filter2D(image, -1, kernel, borderType=cv2.BORDER_REFLECT_101))
    if rng.random() < NOISY:
        noise = rng.normal(0, rng.uniform(2, 8), image.shape[:2])[..., None]
        image = np.clip(image + noise, 0, 255).astype(np.uint8)
    if rng.random() < COMPRESSED:
        image = as_jpeg(image, int(rng.integers(*JPEG_QUALITY)))
    return image


def motion_kernel(length_px: float, angle: float) -> NDArray[np.float32]:
    """The blur of a straight, even motion: float32 (K, K) with a sum of 1, K odd.

    Args:
        length_px: how far a point moves during the exposure.
        angle: of the motion, radians from the x axis towards y.
    """
    reach = int(np.ceil(length_px / 2))
    kernel = np.zeros((2 * reach + 1, 2 * reach + 1), np.float32)
    for step in np.linspace(-length_px / 2, length_px / 2, 4 * reach + 1):
        x, y = reach + step * np.cos(angle), reach + step * np.sin(angle)
        left, top = int(x), int(y)
        for column, across in ((left, 1 - x + left), (left + 1, x - left)):
            for row, down in ((top, 1 - y + top), (top + 1, y - top)):
                if across * down > 0:
                    kernel[row, column] += across * down
    return np.asarray(kernel / kernel.sum(), np.float32)


def as_jpeg(image: NDArray[np.uint8], quality: int) -> NDArray[np.uint8]:
    """The picture, uint8 (H, W, 3), RGB, after it was saved as JPEG."""
    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    encoded = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    return _uint8(cv2.cvtColor(cv2.imdecode(encoded, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB))


def _uint8(image: object) -> NDArray[np.uint8]:
    return np.asarray(image, np.uint8)
