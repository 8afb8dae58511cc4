"""Small vectors."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


def vector(values: Sequence[float]) -> NDArray[np.float32]:
    """A colour or a direction, float32."""
    return np.array(values, dtype=np.float32)


def offset(x: float, y: float, z: float) -> NDArray[np.float64]:
    """A way to go, float64 (3,)."""
    return np.array((x, y, z), dtype=np.float64)
