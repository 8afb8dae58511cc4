"""A scene as triangles."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.scenes.assets.materials import Material
from footprints_edge_models.scenes.assets.things import Thing, ThingPart, composed
from footprints_edge_models.scenes.layout.scene import Scene
from footprints_edge_models.scenes.rendering.raycast import Holes, Triangles

GROUND = -1
"""The index in ``thing`` of walkable ground."""
KERB = -2
"""The index in ``thing`` of sides of walkable ground, which are neither ground nor a thing."""
KERB_M = 0.03
"""Patches this high get faces down to the road."""
GRAINED = frozenset({"wood", "planks", "bark", "metal", "fabric"})
"""Textures whose grain runs along the longer side of a part."""


@dataclass(frozen=True)
class Geometry:
    """All triangles of a scene, in the world.

    Attributes:
        points: float32 (P, 3), the corners of triangles.
        triangles: int32 (T, 3), the points of each.
        normals: float32 (T, 3, 3), unit, at the corners.
        uv: float32 (T, 3, 2), metres along the surface.
        material: int32 (T,), index into ``materials``.
        thing: int32 (T,), index into the scene's things, or GROUND, or KERB.
        part: int32 (T,), unique for each part and patch.
        materials: what the surfaces are made of.
        is_wall: bool (T,), whether the triangle's thing is a wall.
        outlines: float32 (F, 3, 3), the footprints of things, as level triangles: at z = 0, or
            where there are storeys at the height of a thing's floor.
        outline_thing: int32 (F,), the thing of each.
        storeys: whether ground is taken only by outlines about as high as it is.
        holes: where rays go through triangles, if they do.
    """

    points: NDArray[np.float32] = field(repr=False)
    triangles: NDArray[np.int32] = field(repr=False)
    normals: NDArray[np.float32] = field(repr=False)
    uv: NDArray[np.float32] = field(repr=False)
    material: NDArray[np.int32] = field(repr=False)
    thing: NDArray[np.int32] = field(repr=False)
    part: NDArray[np.int32] = field(repr=False)
    materials: tuple[Material, ...] = field(repr=False)
    is_wall: NDArray[np.bool_] = field(repr=False)
    outlines: NDArray[np.float32] = field(repr=False)
    outline_thing: NDArray[np.int32] = field(repr=False)
    storeys: bool = False
    holes: Holes | None = field(default=None, repr=False)

    @property
    def corners(self) -> NDArray[np.float32]:
        """Float32 (T, 3, 3)."""
        return self.points[self.triangles]

    @cached_property
    def ground_alone(self) -> Triangles:
        """Ray tracer of the walkable ground, the sides of kerbs included."""
        return Triangles(self.points[self.triangles[self.thing < 0]])

    @cached_property
    def walls_alone(self) -> Triangles:
        """Ray tracer of the walls."""
        return Triangles(self.points[self.triangles[self.is_wall]])

    @cached_property
    def normal_planes(self) -> NDArray[np.float32]:
        """The normals as (corner, xyz, triangle): numpy is slow at axes of three that come last."""
        return np.ascontiguousarray(self.normals.transpose(1, 2, 0))

    @cached_property
    def uv_planes(self) -> NDArray[np.float32]:
        """``uv`` as (corner, uv, triangle)."""
        return np.ascontiguousarray(self.uv.transpose(1, 2, 0))


def geometry_of(scene: Scene) -> Geometry:
    """The triangles of ground and things."""
    materials: dict[Material, int] = {}
    things = _things(scene, materials)
    ground = _ground(scene, materials)
    points = np.concatenate([ground.points, things.points])
    points[:, 2] += points[:, 0] * scene.slope[0] + points[:, 1] * scene.slope[1]
    thing = np.concatenate([ground.thing, things.thing])
    walls = np.array([thing.is_wall for thing in scene.things] + [False, False])
    outlines, outline_thing = _outlines(scene)
    return Geometry(
        points,
        np.concatenate([ground.triangles, things.triangles + np.int32(len(ground.points))]),
        np.concatenate([ground.normals, things.normals]),
        np.concatenate([ground.uv, things.uv]),
        np.concatenate([ground.material, things.material]),
        thing,
        np.concatenate([ground.part, things.part]),
        tuple(materials),
        walls[thing],
        outlines,
        outline_thing,
        bool(scene.floors),
        _holes(scene, len(ground.triangles)) if scene.floors else None,
    )


def _holes(scene: Scene, first: int) -> Holes | None:
    """Where rays go through things, whose triangles begin at number ``first``."""
    masks, starts, ends, uvs = [], [], [], []
    at = first
    for part, *_ in _placed(scene, {}):
        count = len(part.shape.corners)
        if part.shape.opaque is not None and part.shape.uv is not None:
            masks.append(part.shape.opaque)
            starts.append(at)
            ends.append(at + count)
            uvs.append(part.shape.uv / np.float32(part.material.tile_m))
        at += count
    return Holes.over(at, starts, ends, uvs, masks) if masks else None


@dataclass(frozen=True)
class _Piece:
    """Some of a scene's triangles; see :class:`Geometry`."""

    points: NDArray[np.float32]
    triangles: NDArray[np.int32]
    normals: NDArray[np.float32]
    uv: NDArray[np.float32]
    material: NDArray[np.int32]
    thing: NDArray[np.int32]
    part: NDArray[np.int32]


_Placed: TypeAlias = tuple[ThingPart, Thing, int, int, int]
"""A part, its thing, and the numbers of its thing, its material and itself."""


def _groups(scene: Scene, materials: dict[Material, int]) -> dict[int, list[_Placed]]:
    """The parts of things, and floors, by their shape."""
    groups: dict[int, list[_Placed]] = {}
    number = len(scene.ground)
    things = list(enumerate(scene.things))
    things.append((GROUND, Thing("floor", scene.floors)))
    things.append((KERB, Thing("kerb", scene.kerbs)))
    for index, thing in things:
        for part in thing.parts:
            material = materials.setdefault(part.material, len(materials))
            groups.setdefault(id(part.shape), []).append((part, thing, index, material, number))
            number += 1
    return groups


def _placed(scene: Scene, materials: dict[Material, int]) -> list[_Placed]:
    """The parts of things in the order of their triangles."""
    return [entry for group in _groups(scene, materials).values() for entry in group]


def _things(scene: Scene, materials: dict[Material, int]) -> _Piece:
    """The triangles of things; those of parts of one shape follow each other."""
    groups = _groups(scene, materials)
    if not groups:
        nothing = np.zeros(0, np.int32)
        corners = np.zeros((0, 3, 3), np.float32)
        return _Piece(
            corners[:, 0], nothing.reshape(0, 3), corners, corners[..., :2], *(nothing,) * 3
        )
    placed = [entry for group in groups.values() for entry in group]
    parts = [part for part, *_ in placed]
    matrices = composed(
        np.array([thing.pose for _, thing, *_ in placed]), np.array([p.matrix for p in parts])
    )
    turns, moves = matrices[..., :3].astype(np.float32), matrices[..., 3].astype(np.float32)
    back = np.linalg.inv(matrices[..., :3]).astype(np.float32)
    points, triangles, normals = [], [], []
    first, used = 0, 0
    for group in groups.values():
        shape, count = group[0][0].shape, len(group)
        own = slice(first, first + count)
        at = shape.outline.astype(np.float32) @ turns[own].transpose(0, 2, 1) + moves[own, None]
        starts = used + len(shape.outline) * np.arange(count, dtype=np.int32)
        points.append(at.reshape(-1, 3))
        triangles.append((shape.triangles + starts[:, None, None]).reshape(-1, 3))
        normals.append((shape.normals.reshape(-1, 3) @ back[own]).reshape(-1, 3))
        first, used = first + count, used + len(points[-1])
    of_part = np.repeat(np.arange(len(parts)), [len(part.shape.corners) for part in parts])
    numbers = np.array([number for *_, number in placed], np.int32)
    return _Piece(
        np.concatenate(points),
        np.concatenate(triangles),
        _unit(np.concatenate(normals)).reshape(-1, 3, 3),
        _uv(parts, turns, numbers, of_part),
        np.array([material for *_, material, _ in placed], np.int32)[of_part],
        np.array([index for _, _, index, *_ in placed], np.int32)[of_part],
        numbers[of_part],
    )


def _uv(
    parts: list[ThingPart],
    turns: NDArray[np.float32],
    numbers: NDArray[np.int32],
    of_part: NDArray[np.int64],
) -> NDArray[np.float32]:
    """Metres along the faces of parts, (T, 3, 2), shifted from part to part; of models, their own.

    Args:
        parts: M of them.
        turns: (M, 3, 3), from their templates to the world, without the way.
        numbers: (M,), their own.
        of_part: (T,), which part each triangle is of.
    """
    own = np.array([part.shape.uv is not None for part in parts])
    if not own.any():
        return _planar_uv(parts, turns, numbers, of_part)
    uv = np.empty((len(of_part), 3, 2), np.float32)
    whose = own[of_part]
    uv[whose] = np.concatenate([part.shape.uv for part in parts if part.shape.uv is not None])
    if len(others := np.flatnonzero(~own)):
        rest = of_part[~whose]
        among = np.searchsorted(others, rest)
        uv[~whose] = _planar_uv([parts[k] for k in others], turns[others], numbers[others], among)
    return uv


def _planar_uv(
    parts: list[ThingPart],
    turns: NDArray[np.float32],
    numbers: NDArray[np.int32],
    of_part: NDArray[np.int64],
) -> NDArray[np.float32]:
    """:func:`_uv` of parts without a texture of their own."""
    size = np.linalg.norm(turns, axis=1)  # metres per unit along the template's axes
    extent = size * np.array([part.shape.size for part in parts])
    grained = np.array([part.material.texture.kind in GRAINED for part in parts])
    shift = numbers * 0.377 % 1
    facing = np.concatenate([part.shape.facing for part in parts]) / size[of_part]
    across_x, across_z = (np.argmax(facing, axis=1) == axis for axis in (0, 2))
    corners = np.concatenate([part.shape.corners for part in parts])
    x, y, z = (corners[..., axis] * size[of_part, axis, None] for axis in range(3))
    first, second = np.where(across_x[:, None], y, x), np.where(across_z[:, None], y, z)
    long_x, long_y, long_z = (extent[of_part, axis] for axis in range(3))
    long_first, long_second = np.where(across_x, long_y, long_x), np.where(across_z, long_y, long_z)
    swap = (grained[of_part] & (long_second > long_first))[:, None]
    uv = np.empty((len(corners), 3, 2), np.float32)
    uv[..., 0] = np.where(swap, second, first) + shift[of_part, None]
    uv[..., 1] = np.where(swap, first, second) + shift[of_part, None] * 0.7
    return uv


def _unit(vectors: NDArray[np.float32]) -> NDArray[np.float32]:
    lengths = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    unit: NDArray[np.float32] = vectors / np.maximum(lengths, 1e-12)[:, None]
    return unit


def _ground(scene: Scene, materials: dict[Material, int]) -> _Piece:
    corners, material, part = [], [], []
    for number, patch in enumerate(scene.ground):
        index = materials.setdefault(patch.material, len(materials))
        ring = np.column_stack([patch.outline, np.full(len(patch.outline), patch.height_m)])
        triangles = [(ring[0], ring[k], ring[k + 1]) for k in range(1, len(ring) - 1)]
        if patch.height_m > KERB_M:
            for start, end in zip(ring, np.roll(ring, -1, axis=0), strict=True):
                foot_start, foot_end = start * (1, 1, 0), end * (1, 1, 0)
                triangles += [(foot_start, foot_end, end), (foot_start, end, start)]
        corners += triangles
        material += [index] * len(triangles)
        part += [number] * len(triangles)
    points = np.array(corners, dtype=np.float32).reshape(-1, 3, 3)
    normals = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    normals = _unit(normals)
    upright = np.abs(normals[:, None, 2]) > 0.5
    along = np.where(np.abs(normals[:, None, 0]) > 0.5, points[..., 1], points[..., 0])
    uv = np.where(upright[..., None], points[..., :2], np.stack([along, points[..., 2]], axis=-1))
    return _Piece(
        points.reshape(-1, 3),
        np.arange(3 * len(points), dtype=np.int32).reshape(-1, 3),
        np.repeat(normals[:, None], 3, axis=1),
        uv,
        np.array(material, dtype=np.int32),
        np.full(len(points), GROUND, np.int32),
        np.array(part, dtype=np.int32),
    )


def _outlines(scene: Scene) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """The footprints as triangles, fans of each outline, and the thing of each triangle."""
    rings, owners = [], []
    for index, thing in enumerate(scene.things):
        found = thing.footprints()
        rings += found
        owners += [index] * len(found)
    if not rings:
        return np.zeros((0, 3, 3), np.float32), np.zeros(0, np.int32)
    lengths = np.array([len(ring) for ring in rings])
    first = np.repeat(np.cumsum(lengths) - lengths, lengths - 2)
    step = np.arange(len(first)) - np.repeat(np.cumsum(lengths - 2) - (lengths - 2), lengths - 2)
    corners = np.stack([first, first + step + 1, first + step + 2], axis=1)
    owner = np.repeat(np.array(owners, np.int32), lengths - 2)
    triangles = np.empty((len(first), 3, 3), np.float32)
    triangles[..., :2] = np.concatenate(rings)[corners]
    triangles[..., 2] = np.array([thing.level_m for thing in scene.things])[owner, None]
    return triangles, owner
