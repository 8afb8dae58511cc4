"""A scene in voxels with SSCNet's classes, for the paper's voxel baselines."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .cameras import Camera
from .geometry import GROUND, Geometry
from .raycast import Triangles
from .scene import Scene
from .vectors import vector

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
VOXEL_M = {"rooms": 0.1, "street": 0.2}
FARTHEST_M = {"rooms": 12.0, "street": 36.0}
HIGHEST_M = 3.4


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
    """Fills the part of the world that the camera may see; things go before the floor.

    A voxel belongs to a convex part if its centre lies within a third of a voxel of it, to any
    other part if a corner of one of its triangles lies in it.
    """
    voxel_m, reach_m = VOXEL_M[scene.kind], FARTHEST_M[scene.kind]
    low, high = _seen_range(camera, reach_m)
    shape = np.ceil((high - low) / voxel_m).astype(int)
    labels = np.zeros(shape, np.uint8)
    _lay_floor(labels, geometry, low, voxel_m)
    order = np.argsort(geometry.part, kind="stable")
    starts = np.searchsorted(geometry.part[order], np.arange(int(geometry.part.max()) + 2))
    number = len(scene.ground)
    for thing in scene.things:
        label = CLASSES.index(_CLASS_OF.get(thing.label, "objects"))
        for part in thing.parts:
            corners = geometry.corners[order[starts[number] : starts[number + 1]]]
            number += 1
            at = (corners - low) / voxel_m
            least, most = at.reshape(-1, 3).min(axis=0), at.reshape(-1, 3).max(axis=0)
            if (most < 0).any() or (least > shape).any():
                continue
            _fill(labels, at, label, convex=part.shape.convex)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = camera.rotation, camera.position_m
    return Voxels(labels, low, voxel_m, matrix)


def _seen_range(camera: Camera, reach_m: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    _, directions = camera.rays((8, 8))
    directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    ends = camera.position_m + directions * reach_m
    points = np.vstack([ends, camera.position_m[None]])
    low, high = points.min(axis=0) - 0.5, points.max(axis=0) + 0.5
    foot = camera.position_m[2]
    low[2], high[2] = foot - 3.5, foot + HIGHEST_M
    return low, high


def _lay_floor(
    labels: NDArray[np.uint8], geometry: Geometry, low: NDArray[np.float64], voxel_m: float
) -> None:
    ground = Triangles(geometry.corners[geometry.thing == GROUND])
    x, y = np.meshgrid(*(np.arange(n) for n in labels.shape[:2]), indexing="ij")
    columns = (x.ravel() + 0.5, y.ravel() + 0.5, np.full(x.size, labels.shape[2]))
    points = np.asarray(np.column_stack(columns) * voxel_m + low, dtype=np.float32)
    down = np.tile(vector((0, 0, -1)), (len(points), 1))
    hits = ground.first_hits(points, down)
    level = np.floor((points[:, 2] - hits.distance - low[2]) / voxel_m + 1e-4)
    met = (hits.triangle >= 0) & (level >= 0) & (level < labels.shape[2])
    labels[x.ravel()[met], y.ravel()[met], level[met].astype(int)] = CLASSES.index("floor")


def _fill(
    labels: NDArray[np.uint8], corners: NDArray[np.float64], label: int, *, convex: bool
) -> None:
    """Labels the voxels of one part, whose triangles (T, 3, 3) are in units of voxels."""
    limit = np.array(labels.shape)
    if not convex:
        voxel = np.floor(corners.reshape(-1, 3)).astype(int)
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
