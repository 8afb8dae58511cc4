"""A training sample as one block of bytes: the form that processes hand over and a GPU keeps.

Eight bytes a pixel: red, green, blue and a label byte; two depths as float16.
"""

import math
import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.sample import (
    FOOTPRINT,
    NO,
    UNKNOWN,
    UNLIKELY,
    UNSEEN,
    YES,
    Sample,
    sample_at,
)

VISIBLE_CODES = (NO, YES, UNKNOWN)
"""Labels of visible ground by their code, the label byte's lowest two bits."""
GROUND_CODES = (NO, YES, UNSEEN, FOOTPRINT, UNLIKELY, UNKNOWN)
"""Labels of ground by their code, the next three bits."""
VISIBLE_MASK, GROUND_SHIFT, GROUND_MASK, MOVING_BIT = 3, 2, 7, 32

_HEADER = struct.Struct("<2i4f")


@dataclass(frozen=True)
class StoredView:
    """A sample's pixels.

    Attributes:
        pixels: uint8 (H, W, 4): RGB and the label byte.
        depths_m: float16 (H, W, 2): visible depth, ground depth; 0 = unknown.
        intrinsics: fx, fy, cx, cy in pixels.
    """

    pixels: NDArray[np.uint8]
    depths_m: NDArray[np.float16]
    intrinsics: tuple[float, float, float, float]

    @property
    def size(self) -> tuple[int, int]:
        """(H, W)."""
        return self.pixels.shape[0], self.pixels.shape[1]

    def to_bytes(self) -> bytes:
        """All of it, for :meth:`from_bytes`."""
        return (
            _HEADER.pack(*self.size, *self.intrinsics)
            + self.pixels.tobytes()
            + self.depths_m.tobytes()
        )

    @classmethod
    def from_bytes(cls, data: bytes) -> "StoredView":
        """What :meth:`to_bytes` gave; the arrays share its memory."""
        height, width, *intrinsics = _HEADER.unpack_from(data)
        area = height * width
        pixels = np.frombuffer(data, np.uint8, 4 * area, _HEADER.size)
        depths_m = np.frombuffer(data, np.float16, 2 * area, _HEADER.size + 4 * area)
        return cls(
            pixels.reshape(height, width, 4),
            depths_m.reshape(height, width, 2),
            (intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]),
        )


def stored_view(sample: Sample, most_px: int) -> StoredView:
    """A sample to store, shrunk to at most ``most_px`` pixels."""
    height, width = sample.image.shape[:2]
    if height * width > most_px:
        scale = math.sqrt(most_px / (height * width))
        sample = sample_at(sample, (int(height * scale), int(width * scale)))
    labels = _codes(sample.visible_ground, VISIBLE_CODES)
    labels |= _codes(sample.ground, GROUND_CODES) << GROUND_SHIFT
    if sample.moving is not None:
        labels |= (sample.moving > 0).astype(np.uint8) * np.uint8(MOVING_BIT)
    nothing = np.zeros(labels.shape, np.float16)
    depths = [
        nothing if depth_m is None else depth_m
        for depth_m in (sample.visible_depth_m, sample.ground_depth_m)
    ]
    camera = sample.intrinsics
    return StoredView(
        np.dstack([sample.image, labels]),
        np.stack(depths, axis=-1).astype(np.float16),
        (camera.fx, camera.fy, camera.cx, camera.cy),
    )


def as_sample(view: StoredView, name: str) -> Sample:
    """The sample that a view was made from, but for its size."""
    labels = view.pixels[..., 3]
    return Sample(
        name,
        np.ascontiguousarray(view.pixels[..., :3]),
        Intrinsics(*view.intrinsics),
        np.array(VISIBLE_CODES, np.uint8)[labels & VISIBLE_MASK],
        np.array(GROUND_CODES, np.uint8)[labels >> GROUND_SHIFT & GROUND_MASK],
        np.ascontiguousarray(view.depths_m[..., 0]),
        np.ascontiguousarray(view.depths_m[..., 1]),
        (labels & MOVING_BIT > 0).astype(np.uint8),
    )


def _codes(labels: NDArray[np.uint8], codes: tuple[int, ...]) -> NDArray[np.uint8]:
    table = np.full(256, codes.index(UNKNOWN), np.uint8)
    table[list(codes)] = np.arange(len(codes), dtype=np.uint8)
    return table[labels]
