"""Synthetic photos: seeded, colourful blobs of many sizes with grain, free of anyone's rights."""

import io

import numpy as np
from PIL import Image

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
    buffer = io.BytesIO()
    Image.fromarray(synthetic_photo(size, seed)).save(buffer, "JPEG", quality=90)
    return buffer.getvalue()
