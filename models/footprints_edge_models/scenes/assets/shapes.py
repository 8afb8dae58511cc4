"""Solids to build things from, as triangles.

A shape is a template: it fills x and y from -0.5 to 0.5 and z from 0 to 1 (but for prisms and
lofts, which are given in metres), and a part's matrix brings it to its size and place.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footprints_edge_models.scenes.vectors import cross


@dataclass(frozen=True, eq=False)
class Shape:
    """Triangles of a template.

    Attributes:
        corners: float32 (T, 3, 3): triangle, corner, xyz.
        normals: float32 (T, 3, 3): outward unit normals at the corners; alike at the three corners
            of a flat face.
        convex: whether the solid is the convex hull of its corners.
        uv: float32 (T, 3, 2), in repeats of its own texture; None: metres along its faces.
        mesh: its points (P, 3) and triangles (T, 3), where they are known beforehand.
        opaque: bool (H, W), where its texture is; rays go through it elsewhere. None: everywhere.
    """

    corners: NDArray[np.float32] = field(repr=False)
    normals: NDArray[np.float32] = field(repr=False)
    convex: bool = True
    uv: NDArray[np.float32] | None = field(default=None, repr=False)
    mesh: tuple[NDArray[np.float64], NDArray[np.int32]] | None = field(default=None, repr=False)
    opaque: NDArray[np.bool_] | None = field(default=None, repr=False)

    @cached_property
    def outline(self) -> NDArray[np.float64]:
        """Its different corners, (N, 3): float64 as are the matrices that they are put to."""
        return self._points_and_triangles[0]

    @cached_property
    def triangles(self) -> NDArray[np.int32]:
        """Which of ``outline`` are the corners of each triangle, int32 (T, 3)."""
        return self._points_and_triangles[1]

    @cached_property
    def size(self) -> NDArray[np.float32]:
        """Extent along x, y and z, (3,)."""
        return np.asarray(np.ptp(self.corners.reshape(-1, 3), axis=0))

    @cached_property
    def facing(self) -> NDArray[np.float32]:
        """How much each triangle looks along x, y and z, (T, 3)."""
        return np.asarray(np.abs(self.normals.sum(axis=1)))

    @cached_property
    def _points_and_triangles(self) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        if self.mesh is not None:
            return self.mesh
        points, which = np.unique(self.corners.reshape(-1, 3), axis=0, return_inverse=True)
        return points.astype(np.float64), which.reshape(-1, 3).astype(np.int32)


def loft(sections: ArrayLike, *, smooth: bool = False, convex: bool = True) -> Shape:
    """Skin over rings of points, closed by flat caps.

    Args:
        sections: (N, K, 3): N rings of K points, counter-clockwise as seen from the last ring's
            side; the first and the last are convex.
        smooth: whether normals run smoothly around the skin.
        convex: see :class:`Shape`.
    """
    rings = np.asarray(sections, dtype=np.float64)
    following = np.roll(rings, -1, axis=1)
    low, low_next, high, high_next = rings[:-1], following[:-1], rings[1:], following[1:]
    skin = np.stack(
        [np.stack([low, low_next, high_next], -2), np.stack([low, high_next, high], -2)]
    ).reshape(-1, 3, 3)
    skin_normals = np.repeat(_flat_normals(skin)[:, None], 3, axis=1)
    if smooth:
        around = np.roll(rings, -1, axis=1) - np.roll(rings, 1, axis=1)
        along = np.gradient(rings, axis=0)
        at_points = _unit(cross(around, along))
        following = np.roll(at_points, -1, axis=1)
        low, low_next, high, high_next = (
            at_points[:-1],
            following[:-1],
            at_points[1:],
            following[1:],
        )
        skin_normals = np.stack(
            [np.stack([low, low_next, high_next], -2), np.stack([low, high_next, high], -2)]
        ).reshape(-1, 3, 3)
    caps = np.concatenate([_fan(rings[0][::-1]), _fan(rings[-1])])
    cap_normals = np.repeat(_flat_normals(caps)[:, None], 3, axis=1)
    corners = np.concatenate([skin, caps])
    normals = np.concatenate([skin_normals, cap_normals])
    whole = (
        np.linalg.norm(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        > 1e-12
    )
    return Shape(corners[whole].astype(np.float32), normals[whole].astype(np.float32), convex)


def prism(outline: ArrayLike) -> Shape:
    """A convex outline (K, 2), counter-clockwise from above, as a column from z = 0 to 1."""
    points = np.asarray(outline, dtype=np.float64)
    return loft([np.column_stack([points, np.full(len(points), z)]) for z in (0, 1)])


def ring(sides: int, radius: float = 0.5, turn: float = 0.0) -> NDArray[np.float64]:
    """Points (sides, 2) of a circle, counter-clockwise; the first at ``turn`` sides from +x."""
    angles = (np.arange(sides) + turn) * 2 * np.pi / sides
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


@cache
def unit_box() -> Shape:
    """The box that every template fills."""
    return prism([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])


@cache
def cone(top: float = 1.0, sides: int = 14) -> Shape:
    """A round column whose radius at the top is ``top`` times that at its foot, 0.5."""
    foot = np.column_stack([ring(sides), np.zeros(sides)])
    head = np.column_stack([ring(sides, 0.5 * max(top, 1e-3)), np.ones(sides)])
    return loft([foot, head], smooth=True)


@cache
def ellipsoid(squareness: float = 1.0, sides: int = 14, rings: int = 8) -> Shape:
    """A ball; below 1 a cushion, near 0 a box with rounded edges (a superellipsoid's exponent)."""
    heights = np.linspace(-np.pi / 2 + 0.05, np.pi / 2 - 0.05, rings)
    angles = (np.arange(sides) + 0.5) * 2 * np.pi / sides

    def bent(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.sign(x) * np.abs(x) ** squareness

    sections = np.empty((rings, sides, 3))
    sections[..., 0] = 0.5 * bent(np.cos(heights))[:, None] * bent(np.cos(angles))
    sections[..., 1] = 0.5 * bent(np.cos(heights))[:, None] * bent(np.sin(angles))
    sections[..., 2] = 0.5 + 0.5 * bent(np.sin(heights))[:, None]
    return loft(sections, smooth=True)


def lathe(profile: Sequence[tuple[float, float]], sides: int = 14) -> Shape:
    """A profile of (radius, z) turned about the z axis; radius 0.5 fills the template."""
    sections = [
        np.column_stack([ring(sides, max(radius, 1e-3)), np.full(sides, z)])
        for radius, z in profile
    ]
    return loft(sections, smooth=True, convex=False)


@cache
def leaves(variant: int, count: int = 160, size: float = 0.16) -> Shape:
    """Leaves that fill a ball, denser at its skin; normals point out of the ball."""
    rng = np.random.default_rng(variant)
    centres = _unit(rng.normal(size=(count, 3)))
    clumps = 1 - 0.35 * np.abs(np.sin(centres @ rng.normal(0, 4, (3, 3)))).mean(axis=1)
    centres *= (clumps * rng.uniform(0.45, 1, count) ** 0.5)[:, None] * 0.5
    first = _unit(rng.normal(size=(count, 3)))
    second = _unit(cross(first, rng.normal(size=(count, 3))))
    long = size * rng.uniform(0.6, 1.3, (count, 1))
    corners = np.stack(
        [centres + first * long, centres + second * long * 0.5, centres - second * long * 0.5], 1
    )
    normals = np.repeat((_unit(centres) + np.array((0, 0, 0.3)))[:, None], 3, axis=1)
    normals = _unit(normals + rng.normal(0, 0.35, (count, 1, 3)))
    corners[..., 2] += 0.5
    return Shape(corners.astype(np.float32), normals.astype(np.float32), convex=False)


def convex_hull_2d(points: NDArray[np.floating]) -> NDArray[np.float64]:
    """Corners (K, 2) of the hull of points (N, 2), counter-clockwise."""
    import cv2

    hull = cv2.convexHull(np.ascontiguousarray(points, dtype=np.float32), clockwise=False)
    return np.asarray(hull[:, 0], dtype=np.float64)


def _fan(ring_: NDArray[np.float64]) -> NDArray[np.float64]:
    first = np.broadcast_to(ring_[0], (len(ring_) - 2, 3))
    return np.stack([first, ring_[1:-1], ring_[2:]], axis=1)


def _flat_normals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    return _unit(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: NDArray[np.float64] = vectors / np.maximum(lengths, 1e-12)
    return unit
