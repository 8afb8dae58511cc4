"""Resizing of maps."""

import numpy as np
from PIL import Image

from footprints_edge.foundation.types import Floats, Size


def resize_map(values: Floats, size: Size) -> Floats:
    """Resizes a map, float32 (h, w): bilinear, antialiased when it shrinks."""
    height, width = size
    image = Image.fromarray(values).resize((width, height), Image.Resampling.BILINEAR)
    return np.array(image)


def resize_rows(values: Floats, size: Size, rows: slice) -> Floats:
    """Some rows of what `resize_map` gives, computed alone; `rows` has a start and a stop."""
    height, width = size
    scale = values.shape[0] / height
    box = (0, rows.start * scale, values.shape[1], rows.stop * scale)
    wanted = (width, rows.stop - rows.start)
    return np.array(Image.fromarray(values).resize(wanted, Image.Resampling.BILINEAR, box))


def resize_depth(depth_m: Floats, size: Size) -> Floats:
    """Resizes a depth map, float32 (h, w), as inverse depth.

    Along a plane the inverse depth is affine in the pixel, so interpolation keeps planes flat.
    """
    return np.reciprocal(resize_map(np.reciprocal(depth_m), size))
