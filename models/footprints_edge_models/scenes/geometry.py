"""A scene as triangles."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .materials import Material
from .scene import Scene
from .shapes import Shape
from .things import Part, composed

GROUND = -1
"""The thing that walkable ground belongs to."""
KERB_M = 0.03
"""Patches this high get faces down to the road."""
GRAINED = frozenset({"wood", "planks", "bark", "metal", "fabric"})
"""Textures whose grain runs along the longer side of a part."""


@dataclass(frozen=True)
class Geometry:
    """All triangles of a scene, in the world.

    Attributes:
        corners: float32 (T, 3, 3).
        normals: float32 (T, 3, 3), unit, at the corners.
        uv: float32 (T, 3, 2), metres along the surface.
        material: int32 (T,), index into ``materials``.
        thing: int32 (T,), index into the scene's things, or GROUND.
        part: int32 (T,), unique for each part and patch.
        materials: what the surfaces are made of.
        is_wall: bool (T,), whether the triangle's thing is a wall.
        outlines: float32 (F, 3, 3), the ground that things take, as triangles at z = 0.
        outline_thing: int32 (F,), whose it is.
    """

    corners: NDArray[np.float32] = field(repr=False)
    normals: NDArray[np.float32] = field(repr=False)
    uv: NDArray[np.float32] = field(repr=False)
    material: NDArray[np.int32] = field(repr=False)
    thing: NDArray[np.int32] = field(repr=False)
    part: NDArray[np.int32] = field(repr=False)
    materials: tuple[Material, ...] = field(repr=False)
    is_wall: NDArray[np.bool_] = field(repr=False)
    outlines: NDArray[np.float32] = field(repr=False)
    outline_thing: NDArray[np.int32] = field(repr=False)


def geometry_of(scene: Scene) -> Geometry:
    """The triangles of ground and things."""
    materials: dict[Material, int] = {}
    groups: dict[
        int, tuple[Shape, list[NDArray[np.float64]], list[Part], list[int], list[int]]
    ] = {}
    number = len(scene.ground)
    for index, thing in enumerate(scene.things):
        for part in thing.parts:
            materials.setdefault(part.material, len(materials))
            shape, matrices, parts, things, numbers = groups.setdefault(
                id(part.shape), (part.shape, [], [], [], [])
            )
            matrices.append(composed(thing.pose, part.matrix))
            parts.append(part)
            things.append(index)
            numbers.append(number)
            number += 1
    pieces = [_ground(scene, materials)]
    for shape, matrices, parts, things, numbers in groups.values():
        pieces.append(
            _placed(
                shape,
                np.stack(matrices),
                np.array([materials[p.material] for p in parts]),
                np.array([p.material.texture.kind in GRAINED for p in parts]),
                np.array(things),
                np.array(numbers),
            )
        )
    corners, normals, uv, material, thing_of, part_of = (
        np.concatenate([piece[k] for piece in pieces]) for k in range(6)
    )
    corners[..., 2] += corners[..., 0] * scene.slope[0] + corners[..., 1] * scene.slope[1]
    walls = np.array([thing.is_wall for thing in scene.things] + [False])
    outlines, outline_thing = _outlines(scene)
    return Geometry(
        corners.astype(np.float32),
        normals.astype(np.float32),
        uv.astype(np.float32),
        material.astype(np.int32),
        thing_of.astype(np.int32),
        part_of.astype(np.int32),
        tuple(materials),
        walls[thing_of],
        outlines,
        outline_thing,
    )


_Piece = tuple[NDArray[np.float32], ...]


def _placed(
    shape: Shape,
    matrices: NDArray[np.float64],
    material: NDArray[np.int64],
    grained: NDArray[np.bool_],
    things: NDArray[np.int64],
    numbers: NDArray[np.int64],
) -> tuple[NDArray[np.generic], ...]:
    """Many parts of one shape: arrays of all their triangles."""
    turns, moves = matrices[:, :, :3].astype(np.float32), matrices[:, :, 3].astype(np.float32)
    count, each = len(matrices), len(shape.corners)
    flat = shape.corners.reshape(-1, 3)
    corners = flat @ turns.transpose(0, 2, 1) + moves[:, None]
    inverse = np.linalg.inv(matrices[:, :, :3]).astype(np.float32)
    normals = shape.normals.reshape(-1, 3) @ inverse
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    size = np.linalg.norm(turns, axis=1)  # metres per unit along the template's axes
    metric = flat * size[:, None]
    facing = np.abs(shape.normals.sum(axis=1)) / size[:, None]
    axis = np.repeat(np.argmax(facing, axis=-1), 3, axis=1)
    first = np.where(axis == 0, metric[..., 1], metric[..., 0])
    second = np.where(axis == 2, metric[..., 1], metric[..., 2])
    extent = size * np.ptp(flat, axis=0)
    long_first = np.where(axis == 0, extent[:, None, 1], extent[:, None, 0])
    long_second = np.where(axis == 2, extent[:, None, 1], extent[:, None, 2])
    swap = grained[:, None] & (long_second > long_first)
    shift = (numbers * 0.377 % 1)[:, None]
    uv = np.stack(
        [np.where(swap, second, first) + shift, np.where(swap, first, second) + shift * 0.7], -1
    )
    return (
        corners.reshape(-1, 3, 3),
        normals.reshape(-1, 3, 3),
        uv.reshape(-1, 3, 2),
        np.repeat(material, each),
        np.repeat(things, each),
        np.repeat(numbers, each) if count else numbers,
    )


def _ground(scene: Scene, materials: dict[Material, int]) -> tuple[NDArray[np.generic], ...]:
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
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    upright = np.abs(normals[:, None, 2]) > 0.5
    along = np.where(np.abs(normals[:, None, 0]) > 0.5, points[..., 1], points[..., 0])
    uv = np.where(upright[..., None], points[..., :2], np.stack([along, points[..., 2]], axis=-1))
    return (
        points,
        np.repeat(normals[:, None], 3, axis=1),
        uv,
        np.array(material, dtype=np.int64),
        np.full(len(points), GROUND, np.int64),
        np.array(part, dtype=np.int64),
    )


def _outlines(scene: Scene) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    triangles, owners = [], []
    for index, thing in enumerate(scene.things):
        for outline in thing.footprints():
            ring = np.column_stack([outline, np.zeros(len(outline))])
            triangles += [(ring[0], ring[k], ring[k + 1]) for k in range(1, len(ring) - 1)]
            owners += [index] * (len(ring) - 2)
    return np.array(triangles, np.float32).reshape(-1, 3, 3), np.array(owners, np.int32)
