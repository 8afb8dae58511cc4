"""Things made of parts, their placement and their footprints.

World axes: x and y along the ground, z up, metres.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footprints_edge_models.asset_files.outlines import STANDS_BELOW_M
from footprints_edge_models.scenes.assets.materials import Material
from footprints_edge_models.scenes.assets.shapes import (
    Shape,
    cone,
    convex_hull_2d,
    ellipsoid,
    leaves,
    prism,
    unit_box,
)

_HERE = np.eye(3, 4)


@dataclass(frozen=True)
class ThingPart:
    """A solid of one material.

    Attributes:
        shape: its template.
        matrix: (3, 4), from the template to the thing's axes.
        material: what its surface looks like.
    """

    shape: Shape
    matrix: NDArray[np.float64] = field(repr=False)
    material: Material


@dataclass(frozen=True)
class Thing:
    """An object of a scene.

    Attributes:
        label: its class.
        parts: in the thing's own axes: z = 0 is the ground below it.
        outlines: convex outlines (K, 2) of its footprint, in its own axes; None derives them from
            the parts that reach below STANDS_BELOW_M.
        is_wall: whether it is a building or bounds a room or a garden: ground behind it belongs to
            another place.
        asset: key of the model that it is; empty if it is built from parts.
        level_m: height of the floor that it stands on, in places with storeys.
        pose: (3, 4), from its own axes to the world's.
    """

    label: str
    parts: tuple[ThingPart, ...]
    outlines: tuple[NDArray[np.float64], ...] | None = None
    is_wall: bool = False
    asset: str = ""
    level_m: float = 0.0
    pose: NDArray[np.float64] = field(default_factory=lambda: np.eye(3, 4), repr=False)

    def at(self, x: float, y: float, z: float = 0.0, yaw: float = 0.0) -> "Thing":
        """The same thing at another place, its +y axis turned by ``yaw`` radians, anticlockwise."""
        return replace(self, pose=composed(placement(x, y, z, yaw), self.pose))

    def footprints(self) -> list[NDArray[np.float64]]:
        """Convex outlines (K, 2) of its footprint, in the world."""
        if self.outlines is not None:
            if (self.pose[:2] == _HERE[:2]).all():
                return list(self.outlines)
            turned = self.pose[:2, :2]
            return [outline @ turned.T + self.pose[:2, 3] for outline in self.outlines]
        outlines = []
        for part in self.parts:
            points = part.shape.outline @ part.matrix[:, :3].T + part.matrix[:, 3]
            if points[:, 2].min() < STANDS_BELOW_M:
                world = points @ self.pose[:2, :3].T + self.pose[:2, 3]
                outlines.append(convex_hull_2d(world))
        return outlines

    @cached_property
    def extent(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Least and greatest corner (3,) of the box around it, in its own axes."""
        points = np.concatenate(
            [p.shape.outline @ p.matrix[:, :3].T + p.matrix[:, 3] for p in self.parts]
        )
        return points.min(axis=0), points.max(axis=0)


@dataclass(frozen=True)
class Patch:
    """Walkable surface: a convex outline (K, 2) in the world, counter-clockwise, at one height."""

    outline: NDArray[np.float64]
    height_m: float
    material: Material


def placement(x: float, y: float, z: float = 0.0, yaw: float = 0.0) -> NDArray[np.float64]:
    """The matrix (3, 4) that turns about z and moves."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.array([[cos, -sin, 0, x], [sin, cos, 0, y], [0, 0, 1, z]], dtype=np.float64)


def composed(outer: NDArray[np.float64], inner: NDArray[np.float64]) -> NDArray[np.float64]:
    """The matrices (..., 3, 4) of ``outer`` after ``inner``."""
    matrix: NDArray[np.float64] = outer[..., :3] @ inner
    matrix[..., 3] += outer[..., 3]
    return matrix


def _sized(
    shape: Shape, material: Material, size: ArrayLike, at: ArrayLike, yaw: float, lean: float = 0.0
) -> ThingPart:
    matrix = np.zeros((3, 4))
    matrix.reshape(-1)[::5] = size  # its diagonal
    if lean:
        cos, sin = np.cos(lean), np.sin(lean)
        matrix[:, :3] = np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]]) @ matrix[:, :3]
    if yaw:
        matrix[:, :3] = placement(0, 0, 0, yaw)[:, :3] @ matrix[:, :3]
    matrix[:, 3] = at
    return ThingPart(shape, matrix, material)


def box(
    material: Material, size: ArrayLike, at: ArrayLike, yaw: float = 0.0, lean: float = 0.0
) -> ThingPart:
    """A box; ``at`` is the middle of its underside, ``lean`` tips its top towards -y."""
    return _sized(unit_box(), material, size, at, yaw, lean)


def column(
    material: Material,
    diameter_m: float,
    height_m: float,
    at: ArrayLike,
    *,
    top: float = 1.0,
    sides: int = 14,
) -> ThingPart:
    """A round column standing at ``at``; ``top`` is its upper radius over its lower one."""
    return _sized(cone(top, sides), material, (diameter_m, diameter_m, height_m), at, 0)


def blob(material: Material, size: ArrayLike, at: ArrayLike, yaw: float = 0.0) -> ThingPart:
    """An ellipsoid; ``at`` is the middle of its underside."""
    return _sized(ellipsoid(1.0, 12, 7), material, size, at, yaw)


def joint(material: Material, diameter_m: float, at: ArrayLike) -> ThingPart:
    """A small ball around ``at``, where two rods meet."""
    centre = np.asarray(at, dtype=np.float64) - (0, 0, diameter_m / 2)
    return _sized(ellipsoid(1.0, 8, 5), material, (diameter_m,) * 3, centre, 0)


def cushion(
    material: Material,
    size: ArrayLike,
    at: ArrayLike,
    yaw: float = 0.0,
    *,
    lean: float = 0.0,
    squareness: float = 0.25,
) -> ThingPart:
    """A box with rounded edges; ``at`` is the middle of its underside."""
    fineness = (14, 7) if max(np.asarray(size)) > 0.35 else (10, 5)
    return _sized(ellipsoid(squareness, *fineness), material, size, at, yaw, lean)


def foliage(
    material: Material, size: ArrayLike, at: ArrayLike, variant: int, count: int, leaf: float
) -> ThingPart:
    """A ball of ``count`` leaves, each ``leaf`` of its diameter long."""
    return _sized(leaves(variant, count, leaf), material, size, at, 0)


def rod(
    material: Material,
    start: ArrayLike,
    end: ArrayLike,
    diameter_m: float,
    *,
    top: float = 1.0,
    sides: int = 8,
) -> ThingPart:
    """A round rod between two points."""
    x0, y0, z0 = (float(v) for v in np.asarray(start))
    x1, y1, z1 = (float(v) for v in np.asarray(end))
    x, y, z = x1 - x0, y1 - y0, z1 - z0
    length = math.sqrt(x * x + y * y + z * z)
    flat = math.hypot(x, y)
    if flat > 1e-6 * length:  # one side level, the other at right angles to both
        side = (-y / flat, x / flat, 0.0)
        other = (-x * z / (flat * length), -y * z / (flat * length), flat / length)
    else:
        side, other = (1.0, 0.0, 0.0), (0.0, math.copysign(1.0, z), 0.0)
    d = diameter_m
    matrix = np.array(
        [[side[k] * d, other[k] * d, (x, y, z)[k], (x0, y0, z0)[k]] for k in range(3)]
    )
    return ThingPart(cone(top, sides), matrix, material)


def disc_on_side(
    material: Material, diameter_m: float, width_m: float, at: ArrayLike, sides: int = 16
) -> ThingPart:
    """A wheel: a disc whose axle runs along x, ``at`` the middle of its hub."""
    centre = np.asarray(at, dtype=np.float64)
    half = np.array([width_m / 2, 0, 0])
    return rod(material, centre - half, centre + half, diameter_m, sides=sides)


def extruded(material: Material, outline: ArrayLike, height_m: float, z: float = 0.0) -> ThingPart:
    """A convex outline (K, 2) in metres, counter-clockwise, as a column."""
    matrix = np.eye(3, 4)
    matrix[2] = (0, 0, height_m, z)
    return ThingPart(prism(outline), matrix, material)


def rectangle(x0: float, y0: float, x1: float, y1: float) -> NDArray[np.float64]:
    """Corners (4, 2), counter-clockwise."""
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], dtype=np.float64)


def shifted(
    parts: Iterable[ThingPart], x: float, y: float, z: float = 0.0, yaw: float = 0.0
) -> list[ThingPart]:
    """Parts of a smaller thing, moved to their place in a larger one."""
    move = placement(x, y, z, yaw)
    return [replace(part, matrix=composed(move, part.matrix)) for part in parts]


def extended(thing: Thing, label: str, parts: Sequence[ThingPart]) -> Thing:
    """A thing with more parts, such as a chair with somebody on it.

    It stays the model that it is, if it is one: the parts take ground of their own.
    """
    outlines = thing.outlines
    if outlines is not None:
        outlines = (*outlines, *Thing(label, tuple(parts)).footprints())
    return replace(thing, label=label, parts=(*thing.parts, *parts), outlines=outlines)


def joined(label: str, parts: Sequence[ThingPart], **options: object) -> Thing:
    """A thing of these parts."""
    return Thing(label, tuple(parts), **options)  # type: ignore[arg-type]
