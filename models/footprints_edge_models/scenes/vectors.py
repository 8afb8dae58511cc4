"""Small vectors."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray


def vector(values: Sequence[float]) -> NDArray[np.float32]:
    """A colour or a direction, float32."""
    return np.array(values, dtype=np.float32)


def offset(x: float, y: float, z: float) -> NDArray[np.float64]:
    """A way to go, float64 (3,)."""
    return np.array((x, y, z), dtype=np.float64)


def dot(first: NDArray[np.float32], second: NDArray[np.float32]) -> NDArray[np.float32]:
    """Dot products (N,) of vectors (3, N)."""
    return np.asarray(first[0] * second[0] + first[1] * second[1] + first[2] * second[2])


def cross(first: NDArray[Any], second: NDArray[Any]) -> NDArray[Any]:
    """Cross products of vectors whose last axis is x, y, z; numpy's takes long on few of them."""
    a, b, c = (first[..., axis] for axis in range(3))
    x, y, z = (second[..., axis] for axis in range(3))
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=-1)
