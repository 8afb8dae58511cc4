"""Planes, and the robust fit of one."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.floating]
"""(N, 3), metres."""

_SCORED = 2000
"""Hypotheses are scored on at most this many points: more do not change their order."""


@dataclass(frozen=True)
class Plane:
    """Points x with normal . x = offset_m; the normal is of unit length."""

    normal: NDArray[np.float64]
    offset_m: float

    @classmethod
    def through(cls, points: Points) -> "Plane":
        """The least-squares plane of at least three points; which way it faces is left open."""
        centre = points.mean(axis=0, dtype=np.float64)
        spread = (points - centre).astype(np.float64)
        normal = np.linalg.eigh(spread.T @ spread)[1][:, 0]  # the direction of least spread
        return cls(normal, float(normal @ centre))

    def facing(self, direction: NDArray[np.floating]) -> "Plane":
        """The same plane with its normal on the side of ``direction``."""
        if self.normal @ direction < 0:
            return Plane(-self.normal, -self.offset_m)
        return self

    def axes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Two unit directions in the plane, at right angles."""
        helper = np.eye(3)[np.argmin(np.abs(self.normal))]
        first = np.cross(self.normal, helper)
        first /= np.linalg.norm(first)
        return first, np.cross(self.normal, first)

    def depth_m(self, rays: NDArray[np.floating]) -> NDArray[np.floating]:
        """Depth where rays (..., 3) from the origin, z = 1, meet the plane; infinite if never."""
        with np.errstate(divide="ignore", invalid="ignore"):
            meets_m = self.offset_m / (rays @ self.normal)
        return np.where(meets_m > 0, meets_m, np.inf)

    def height_m(self, points: NDArray[np.floating]) -> NDArray[np.floating]:
        """Signed distance of points (..., 3) from the plane along its normal, metres."""
        return points @ self.normal - self.offset_m


def fit_plane(
    points: Points,
    rng: np.random.Generator,
    inlier_m: float = 0.05,
    trials: int = 100,
    accept: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.bool_]] | None = None,
) -> Plane | None:
    """The plane that most points lie on, by RANSAC, refitted to its inliers.

    Args:
        points: (N, 3), metres.
        rng: draws the triples.
        inlier_m: points nearer to a plane than this lie on it.
        trials: triples drawn (the paper's reference implementation: 100).
        accept: which hypotheses are allowed, given unit normals (trials, 3) and offsets (trials,).

    Returns:
        The plane, or None where fewer than three points are given or no hypothesis is accepted.
    """
    if len(points) < 3:
        return None
    triples = points[rng.integers(len(points), size=(trials, 3))].astype(np.float64)
    normals = np.cross(triples[:, 1] - triples[:, 0], triples[:, 2] - triples[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    usable = lengths > 1e-9  # a point drawn twice, or three in a row, spans no plane
    normals = normals[usable] / lengths[usable, None]
    offsets = (normals * triples[usable, 0]).sum(axis=1)
    if accept is not None:
        kept = accept(normals, offsets)
        normals, offsets = normals[kept], offsets[kept]
    if not len(normals):
        return None
    scored = points
    if len(points) > _SCORED:
        scored = points[rng.choice(len(points), _SCORED, replace=False)]
    votes = (np.abs(scored @ normals.T - offsets) < inlier_m).sum(axis=0)
    best = Plane(normals[votes.argmax()], float(offsets[votes.argmax()]))
    inliers = points[np.abs(best.height_m(points)) < inlier_m]
    return Plane.through(inliers).facing(best.normal) if len(inliers) >= 3 else best
