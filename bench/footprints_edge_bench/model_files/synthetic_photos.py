"""Made-up photos: coloured blobs of many sizes and a grain, seeded. Nobody's picture."""

import io

import numpy as np
from PIL import Image

from footprints_edge.foundation.types import Rgb, Size

_GRAIN = 4.0
"""Standard deviation of the grain, in steps of 255: it makes a JPEG of 12 million pixels as large
as a phone's."""


def synthetic_photo(size: Size, seed: int) -> Rgb:
    """A picture of a size, uint8 (H, W, 3); another one for each seed."""
    height, width = size
    rng = np.random.default_rng(seed)
    picture = np.zeros((height, width, 3), np.float32)
    for side in (3, 8, 21, 55):
        blobs = rng.integers(0, 256, (side, side, 3), np.uint8)
        drawn = Image.fromarray(blobs).resize((width, height), Image.Resampling.BICUBIC)
        picture += np.asarray(drawn, np.float32) / 4
    picture += rng.normal(0, _GRAIN, (height, width, 1)).astype(np.float32)
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def synthetic_jpeg(size: Size, seed: int = 0) -> bytes:
    """The same as the bytes of a JPEG of quality 90."""
    buffer = io.BytesIO()
    Image.fromarray(synthetic_photo(size, seed)).save(buffer, "JPEG", quality=90)
    return buffer.getvalue()
