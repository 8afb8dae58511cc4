"""Oriented boxes around objects and their footprints: the baseline "3D bounding boxes"."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.types import Mask, Size
from footprints_edge.geometry.camera import Intrinsics

_NEAREST_M = 0.05
"""Footprints are clipped to depths from here on, since a camera sees nothing behind itself."""


class BoxesError(FootprintsError):
    """A file of boxes is missing or malformed."""


@dataclass(frozen=True, eq=False)
class Box:
    """A box in camera axes (x right, y down, z forward).

    Attributes:
        centre_m: (3,), metres.
        size_m: (3,), full extent along the box's own axes, metres.
        rotation: (3, 3), the box's axes as columns; the second points down, to its bottom face.
    """

    centre_m: NDArray[np.float64]
    size_m: NDArray[np.float64]
    rotation: NDArray[np.float64]

    def bottom(self) -> NDArray[np.float64]:
        """Corners (4, 3) of the bottom face, metres, in order around it."""
        signs = np.array([[-1, 1, -1], [1, 1, -1], [1, 1, 1], [-1, 1, 1]])
        corners: NDArray[np.float64] = self.centre_m + (signs * self.size_m / 2) @ self.rotation.T
        return corners

    def footprint(self, intrinsics: Intrinsics, size: Size) -> Mask:
        """Pixels (H, W) whose rays meet the bottom face, whether it is visible or hidden."""
        from skimage.draw import polygon

        mask = np.zeros(size, bool)
        corners = _in_front(self.bottom())
        if len(corners) >= 3:
            x, y, z = corners.T
            columns = intrinsics.fx * x / z + intrinsics.cx
            rows = intrinsics.fy * y / z + intrinsics.cy
            mask[polygon(rows, columns, size)] = True
        return mask


def read_boxes(path: Path) -> dict[str, tuple[Box, ...]]:
    """Boxes by image name.

    The file is a JSON object. It maps each image name to a list of boxes with ``centre_m`` [3],
    ``size_m`` [3] and ``rotation`` 3x3, see :class:`Box`.

    Raises:
        BoxesError: the file is missing or malformed.
    """
    try:
        stated = json.loads(path.read_text(encoding="utf-8"))
        return {name: tuple(_box(entry) for entry in entries) for name, entries in stated.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise BoxesError(
            f"{path}: cannot read boxes ({type(error).__name__}: {error}); map each image name to "
            "a list of boxes with centre_m [3], size_m [3], rotation 3x3 (docs/accuracy.md)"
        ) from error


def _box(entry: dict[str, object]) -> Box:
    centre_m, size_m, rotation = (
        np.asarray(entry[key], dtype=np.float64) for key in ("centre_m", "size_m", "rotation")
    )
    if centre_m.shape != (3,) or size_m.shape != (3,) or rotation.shape != (3, 3):
        raise ValueError(f"a box has shapes {centre_m.shape}, {size_m.shape}, {rotation.shape}")
    if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-3):
        raise ValueError(f"{rotation.tolist()} is not a rotation")
    return Box(centre_m, size_m, rotation)


def _in_front(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """The part of a convex polygon (N, 3) that lies in front of the camera."""
    kept = []
    for here, there in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if here[2] >= _NEAREST_M:
            kept.append(here)
        if (here[2] >= _NEAREST_M) != (there[2] >= _NEAREST_M):
            share = (_NEAREST_M - here[2]) / (there[2] - here[2])
            kept.append(here + share * (there - here))
    return np.array(kept).reshape(-1, 3)
