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


_MOST_HOLES = 8
"""A ray that went through so many triangles stops at the next."""
_STEP = np.float32(1e-3)


@dataclass(frozen=True)
class Holes:
    """Where rays go through triangles: between leaves that are painted on a card, say.

    Attributes:
        mask: int32 (T,), index of each triangle's mask; -1 for opaque ones.
        uv: float32 (T, 3, 2), in repeats of the mask, rows down; unused for opaque ones.
        masks: bool (H, W) each, where something is.
    """

    mask: NDArray[np.int32]
    uv: Floats32
    masks: tuple[NDArray[np.bool_], ...]

    @classmethod
    def over(
        cls,
        count: int,
        starts: list[int],
        ends: list[int],
        uvs: list[Floats32],
        masks: list[NDArray[np.bool_]],
    ) -> "Holes":
        """Of ``count`` triangles, those in runs ``starts`` to ``ends`` have masks."""
        which, uv = np.full(count, -1, np.int32), np.zeros((count, 3, 2), np.float32)
        different = {id(mask): mask for mask in masks}
        numbers = {name: number for number, name in enumerate(different)}
        for start, end, coordinates, mask in zip(starts, ends, uvs, masks, strict=True):
            which[start:end], uv[start:end] = numbers[id(mask)], coordinates
        return cls(which, uv, tuple(different.values()))

    def met(self, triangle: NDArray[np.int32], u: Floats32, v: Floats32) -> NDArray[np.bool_]:
        """Whether hits on triangles, -1 for none, are in holes of theirs, bool (N,)."""
        found = np.where(triangle >= 0, self.mask[triangle], -1)
        through = np.zeros(len(triangle), np.bool_)
        for number in np.unique(found[found >= 0]):
            here = np.flatnonzero(found == number)
            mask, corner = self.masks[number], self.uv[triangle[here]]
            u1, v1 = u[here, None], v[here, None]
            at = corner[:, 0] * (1 - u1 - v1) + corner[:, 1] * u1 + corner[:, 2] * v1
            cells = ((at - np.floor(at)) * mask.shape[::-1]).astype(np.int32)
            column, row = np.minimum(cells.T, np.array(mask.shape[::-1])[:, None] - 1)
            through[here] = ~mask[row, column]
        return through


class Triangles:
    """Triangles that rays can be sent at.

    Rays have float32 origins (N, 3), and directions (N, 3), or (1, 3) if all have the same.
    """

    def __init__(
        self,
        corners: Floats32,
        indices: NDArray[np.int32] | None = None,
        holes: Holes | None = None,
    ) -> None:
        """Builds the tree; T may be 0.

        Embree is handed number by number: that takes half as long where triangles share points.

        Args:
            corners: float32 (T, 3, 3), or points (P, 3).
            indices: int32 (T, 3), the three points of each triangle.
            holes: where rays go through.
        """
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._scene, self._holes = None, holes
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
        hits = Hits(triangle, distance, found["u"], found["v"])
        return hits if self._holes is None else self._behind_holes(hits, origins, directions)

    def _behind_holes(self, hits: Hits, origins: Floats32, directions: Floats32) -> Hits:
        """The hits, those in holes replaced by what is behind."""
        assert self._scene is not None and self._holes is not None
        triangle, distance = hits.triangle.copy(), hits.distance.copy()
        u, v = hits.u.copy(), hits.v.copy()
        rays = np.arange(len(triangle))
        for _ in range(_MOST_HOLES):
            rays = rays[self._holes.met(triangle[rays], u[rays], v[rays])]
            if not len(rays):
                break
            own = np.ascontiguousarray(
                directions[rays] if len(directions) > 1 else np.repeat(directions, len(rays), 0)
            )
            start = origins[rays] + own * (distance[rays] + _STEP)[:, None]
            found = self._scene.run(np.ascontiguousarray(start, np.float32), own, output=1)
            met = found["primID"] >= 0
            triangle[rays], u[rays], v[rays] = found["primID"], found["u"], found["v"]
            distance[rays] = np.where(
                met, distance[rays] + _STEP + found["tfar"], np.float32(np.inf)
            )
        return Hits(triangle, distance, u, v)

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
        met = np.asarray(found >= 0)
        if self._holes is not None and met.any():
            some = np.flatnonzero(met)
            own = directions[some] if len(directions) > 1 else directions
            hits = self.first_hits(np.ascontiguousarray(origins[some]), np.ascontiguousarray(own))
            met[some] = hits.distance <= reach[some]
        return met


@cache
def _device() -> object:
    """Embree's own state, one a process: it takes longer to make than a small tree."""
    from embreex.rtcore import EmbreeDevice

    return EmbreeDevice()
