"""A scene in voxels with SSCNet's classes, for the paper's voxel baselines."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.asset_files.world_plan import LOWEST_M
from footprints_edge_models.scenes.layout.scene import Scene
from footprints_edge_models.scenes.rendering.cameras import Camera
from footprints_edge_models.scenes.rendering.geometry import GROUND, Geometry
from footprints_edge_models.scenes.rendering.raycast import Triangles
from footprints_edge_models.scenes.vectors import vector

CLASSES = (
    *("empty", "ceiling", "floor", "wall", "window", "chair", "bed", "sofa", "table", "tvs"),
    *("furniture", "objects"),
)
_CLASS_OF = {
    "ceiling": "ceiling", "beam": "ceiling", "wall": "wall", "building": "wall", "door": "wall",
    "door frame": "wall", "window": "window", "chair": "chair", "stool": "chair",
    "office chair": "chair", "bed": "bed", "sofa": "sofa", "armchair": "sofa", "table": "table",
    "desk": "table", "television": "tvs", "cabinet": "furniture", "shelf": "furniture",
    "counter": "furniture", "fridge": "furniture", "machine": "furniture",
}  # fmt: skip
VOXEL_M = 0.08
SHAPE = (60, 60, 36)
"""SSCNet's own volume, in the voxels that it gives out: 4.8 m across, 4.8 m ahead, 2.88 m high."""
BELOW_FOOT_M = 0.4
"""How far the volume reaches below the ground under the camera: kerbs and slopes lead down, too."""


@dataclass(frozen=True)
class Voxels:
    """Labelled voxels.

    Attributes:
        labels: uint8 (X, Y, Z), index into CLASSES; the third axis points up.
        origin_m: (3,), the corner of voxel (0, 0, 0), in the grid's axes.
        voxel_m: length of an edge.
        camera_to_grid: (4, 4), from camera axes to the grid's.
    """

    labels: NDArray[np.uint8] = field(repr=False)
    origin_m: NDArray[np.float64]
    voxel_m: float
    camera_to_grid: NDArray[np.float64]


def voxels_of(scene: Scene, geometry: Geometry, camera: Camera) -> Voxels:
    """Fills the volume in front of the camera; things go before the floor.

    The grid's axes point right, ahead and up from the ground below the camera. A voxel belongs to a
    convex part if its centre lies within a third of a voxel of it, to any other part if the surface
    of that goes through it. What lies flat on the floor is floor.
    """
    camera_to_grid = _camera_to_grid(geometry, camera)
    low = np.array([-SHAPE[0] * VOXEL_M / 2, 0, -BELOW_FOOT_M])
    world_to_camera = camera.rotation.T
    turned = (geometry.corners - camera.position_m) @ world_to_camera.T
    corners = (turned @ camera_to_grid[:3, :3].T + camera_to_grid[:3, 3] - low) / VOXEL_M
    labels = np.zeros(SHAPE, np.uint8)
    _lay_floor(labels, corners[geometry.thing == GROUND])
    order = np.argsort(geometry.part, kind="stable")
    starts = np.searchsorted(geometry.part[order], np.arange(int(geometry.part.max()) + 2))
    number = len(scene.ground)
    for thing in scene.things:
        label = CLASSES.index(_CLASS_OF.get(thing.label, "objects"))
        foot_m = thing.level_m - thing.pose[2, 3] if thing.level_m else 0.0
        # a thing may have lost all its parts: what was moved away in a world, say
        if thing.parts and thing.extent[1][2] - foot_m < LOWEST_M:
            number += len(thing.parts)
            continue
        for part in thing.parts:
            at = corners[order[starts[number] : starts[number + 1]]]
            number += 1
            least, most = at.reshape(-1, 3).min(axis=0), at.reshape(-1, 3).max(axis=0)
            if (most < 0).any() or (least > SHAPE).any():
                continue
            _fill(labels, at, label, convex=part.shape.convex)
    return Voxels(labels, low, VOXEL_M, camera_to_grid)


def _camera_to_grid(geometry: Geometry, camera: Camera) -> NDArray[np.float64]:
    down = np.array([[0, 0, -1]], np.float32)
    ground = Triangles(geometry.corners[geometry.thing == GROUND])
    height_m = float(
        ground.first_hits(camera.position_m[None].astype(np.float32), down).distance[0]
    )
    # Seen from straight above or below, the picture's upper edge tells what is ahead.
    forward = camera.rotation[:, 2] - 0.01 * camera.rotation[:, 1]
    ahead = np.array([forward[0], forward[1], 0]) / np.hypot(forward[0], forward[1])
    world_to_grid = np.stack([np.cross(ahead, [0, 0, 1]), ahead, [0, 0, 1]])
    matrix = np.eye(4)
    matrix[:3, :3] = world_to_grid @ camera.rotation
    matrix[2, 3] = height_m if np.isfinite(height_m) else 0
    return matrix


def _lay_floor(labels: NDArray[np.uint8], corners: NDArray[np.float64]) -> None:
    """Labels the highest ground of each column; triangles (T, 3, 3) are in units of voxels."""
    ground = Triangles(np.asarray(corners, dtype=np.float32))
    x, y = np.meshgrid(*(np.arange(n) for n in labels.shape[:2]), indexing="ij")
    columns = (x.ravel() + 0.5, y.ravel() + 0.5, np.full(x.size, labels.shape[2]))
    points = np.asarray(np.column_stack(columns), dtype=np.float32)
    down = np.tile(vector((0, 0, -1)), (len(points), 1))
    hits = ground.first_hits(points, down)
    level = np.floor(points[:, 2] - hits.distance + 1e-4)
    met = (hits.triangle >= 0) & (level >= 0)
    labels[x.ravel()[met], y.ravel()[met], level[met].astype(int)] = CLASSES.index("floor")


def _fill(
    labels: NDArray[np.uint8], corners: NDArray[np.float64], label: int, *, convex: bool
) -> None:
    """Labels the voxels of one part, whose triangles (T, 3, 3) are in units of voxels."""
    limit = np.array(labels.shape)
    if not convex:
        voxel = np.floor(_points_on(corners, limit)).astype(int)
        x, y, z = voxel[((voxel >= 0) & (voxel < limit)).all(axis=1)].T
        labels[x, y, z] = label
        return
    points = corners.reshape(-1, 3)
    first = np.maximum(np.floor(points.min(axis=0) - 0.34).astype(int), 0)
    last = np.minimum(np.ceil(points.max(axis=0) + 0.34).astype(int), limit)
    if (last <= first).any():
        return
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1)
    normals = normals[length > 1e-9] / length[length > 1e-9, None]
    offsets = np.einsum("ij,ij->i", normals, corners[length > 1e-9, 0])
    planes = np.unique(np.round(np.column_stack([normals, offsets]), 3), axis=0)
    grid = np.stack(np.meshgrid(*map(np.arange, first, last), indexing="ij"), axis=-1) + 0.5
    inside = np.ones(grid.shape[:3], bool)
    for plane in planes:
        inside &= grid @ plane[:3] <= plane[3] + 0.34
    x, y, z = np.nonzero(inside)
    labels[x + first[0], y + first[1], z + first[2]] = label


def _points_on(corners: NDArray[np.float64], limit: NDArray[np.int_]) -> NDArray[np.float64]:
    """Points (N, 3) on the triangles within the volume, closer to each other than voxels are.

    Triangles are halved at their longest edge until it is no longer than a voxel; halves outside of
    the volume are dropped on the way, so that a house costs no more than what of it is inside.
    """
    points = []
    while len(corners):
        near = ((corners.max(axis=1) >= 0) & (corners.min(axis=1) <= limit)).all(axis=1)
        corners = corners[near]
        lengths = np.linalg.norm(corners[:, [1, 2, 0]] - corners, axis=2)
        small = lengths.max(axis=1) <= 1
        points += [corners[small].reshape(-1, 3), corners[small].mean(axis=1)]
        corners, lengths = corners[~small], lengths[~small]
        first = lengths.argmax(axis=1)
        rows = np.arange(len(corners))
        a, b, c = (corners[rows, (first + step) % 3] for step in range(3))
        middle = (a + b) / 2
        corners = np.concatenate([np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
    return np.concatenate(points) if points else np.empty((0, 3))
