"""Where rays meet triangles. The only file that knows embree."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

Floats32 = NDArray[np.float32]


@dataclass(frozen=True)
class Hits:
    """The first triangle that each ray meets.

    Attributes:
        triangle: int32 (N,), -1 where a ray meets nothing.
        distance: float32 (N,), in lengths of the ray's direction; inf where it meets nothing.
        u: float32 (N,), weight of the triangle's second corner.
        v: float32 (N,), weight of its third corner.
    """

    triangle: NDArray[np.int32]
    distance: Floats32
    u: Floats32
    v: Floats32


class Triangles:
    """Triangles that rays can be sent at.

    Rays have float32 origins (N, 3), and directions (N, 3), or (1, 3) if all have the same.
    """

    def __init__(self, corners: Floats32, indices: NDArray[np.int32] | None = None) -> None:
        """Builds the tree; T may be 0.

        Embree is handed number by number: that takes half as long where triangles share points.

        Args:
            corners: float32 (T, 3, 3), or points (P, 3).
            indices: int32 (T, 3), the three points of each triangle.
        """
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._scene = None
        if len(corners if indices is None else indices):
            self._scene = EmbreeScene(_device())
            TriangleMesh(self._scene, corners, indices)

    def first_hits(self, origins: Floats32, directions: Floats32) -> Hits:
        """The first triangle on each ray."""
        count = len(origins)
        if self._scene is None or not count:
            nothing = np.full(count, -1, np.int32)
            zeros = np.zeros(count, np.float32)
            return Hits(nothing, np.full(count, np.inf, np.float32), zeros, zeros)
        found = self._scene.run(origins, directions, output=1)
        triangle = found["primID"]
        distance = np.where(triangle >= 0, found["tfar"], np.float32(np.inf))
        return Hits(triangle, distance, found["u"], found["v"])

    def distances(self, origins: Floats32, directions: Floats32) -> Floats32:
        """How far each ray gets, float32 (N,), in lengths of its direction; 1e37 if nowhere."""
        if self._scene is None or not len(origins):
            return np.full(len(origins), np.inf, np.float32)
        found = self._scene.run(origins, directions, query="DISTANCE")
        return np.asarray(found, dtype=np.float32)

    def blocked(
        self, origins: Floats32, directions: Floats32, reach: Floats32
    ) -> NDArray[np.bool_]:
        """Whether each ray meets something within ``reach`` lengths of its direction, bool (N,)."""
        if self._scene is None or not len(origins):
            return np.zeros(len(origins), np.bool_)
        reach = np.ascontiguousarray(reach, dtype=np.float32)
        found = self._scene.run(origins, directions, dists=reach, query="OCCLUDED")
        return np.asarray(found >= 0)


@cache
def _device() -> object:
    """Embree's own state, one a process: it takes longer to make than a small tree."""
    from embreex.rtcore import EmbreeDevice

    return EmbreeDevice()
