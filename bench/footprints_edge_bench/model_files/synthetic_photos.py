"""Synthetic photos: seeded, colourful blobs of many sizes with grain, free of anyone's rights."""

import io

import numpy as np
from PIL import Image, ImageOps

from footprints_edge.foundation.types import Rgb, Size

_GRAIN = 4.0
"""Standard deviation of the grain, in steps of 255. It makes the JPEG of 12 million pixels as large
as a phone's."""


def synthetic_photo(size: Size, seed: int) -> Rgb:
    """A photo of size (H, W), uint8 (H, W, 3); each seed gives another one."""
    height, width = size
    rng = np.random.default_rng(seed)
    photo = np.zeros((height, width, 3), np.float32)
    for side in (3, 8, 21, 55):
        blobs = rng.integers(0, 256, (side, side, 3), np.uint8)
        drawn = Image.fromarray(blobs).resize((width, height), Image.Resampling.BICUBIC)
        photo += np.asarray(drawn, np.float32) / 4
    photo += rng.normal(0, _GRAIN, (height, width, 1)).astype(np.float32)
    return np.clip(np.rint(photo), 0, 255).astype(np.uint8)


def synthetic_jpeg(size: Size, seed: int = 0) -> bytes:
    """The same photo as a JPEG of quality 90."""
    return _jpeg(synthetic_photo(size, seed))


def enlarged_jpeg(photo: Rgb, size: Size) -> bytes:
    """The middle of a photo as a JPEG of size (H, W), with the same grain.

    Args:
        photo: uint8 (h, w, 3).
        size: of the result.
    """
    image = ImageOps.fit(Image.fromarray(photo), (size[1], size[0]), Image.Resampling.LANCZOS)
    grain = np.random.default_rng(0).normal(0, _GRAIN, (*size, 1)).astype(np.float32)
    return _jpeg(np.clip(np.rint(np.asarray(image) + grain), 0, 255).astype(np.uint8))


def _jpeg(photo: Rgb) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(photo).save(buffer, "JPEG", quality=90)
    return buffer.getvalue()
