"""A top-down map of a whole clip: which cells of the floor are free, occupied or never seen.

Every frame's depth is lifted into the world and sorted by its height above the floor. The map,
projected into a frame, is that frame's ground, seen or hidden ("a top-down floor map reprojected
into the camera view", paper, section "Our Footprints world model").
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry import Intrinsics, backproject, rays

NEVER_SEEN, FREE, OCCUPIED = 0, 1, 2

FLOOR_HEIGHT_M = 0.05
"""Points nearer to the plane than this are floor."""
LOW_M, BODY_M = 0.35, 1.8
"""Obstacles up to LOW_M stand on the floor; above BODY_M a person passes beneath."""


@dataclass(frozen=True)
class Plane:
    """The floor: points x of the world with normal . x = offset_m; the normal points up, unit."""

    normal: NDArray[np.float64]
    offset_m: float

    def axes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Two unit directions in the plane, at right angles."""
        helper = np.eye(3)[np.argmin(np.abs(self.normal))]
        first = np.cross(self.normal, helper)
        first /= np.linalg.norm(first)
        return first, np.cross(self.normal, first)

    def height_m(self, points: NDArray[np.floating]) -> NDArray[np.floating]:
        """Height of points (..., 3) above the floor, metres."""
        return points @ self.normal - self.offset_m


@dataclass(frozen=True)
class Frame:
    """A depth frame and its camera-to-world pose (4, 4)."""

    depth_m: NDArray[np.float32]
    intrinsics: Intrinsics
    camera_to_world: NDArray[np.float64]

    def points(self) -> NDArray[np.float64]:
        """World points (H, W, 3) of the depth; meaningless where the depth is 0."""
        rotation, translation = self.camera_to_world[:3, :3], self.camera_to_world[:3, 3]
        return backproject(self.depth_m, self.intrinsics) @ rotation.T + translation

    def depth_to_m(self, plane: Plane) -> NDArray[np.float64]:
        """Depth (H, W) at which each pixel's ray meets a plane below it, metres; 0 where none."""
        rotation, translation = self.camera_to_world[:3, :3], self.camera_to_world[:3, 3]
        fall = rays(self.intrinsics, self.depth_m.shape[:2]) @ rotation.T @ plane.normal
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(fall < -1e-6, -plane.height_m(translation) / fall, 0)


def fit_floor(frames: Iterable[Frame], up: NDArray[np.float64]) -> Plane:
    """The lowest well-filled horizontal plane of a clip.

    Args:
        frames: depth frames with poses.
        up: direction against gravity, in the world, any length.
    """
    up = up / np.linalg.norm(up)
    points = np.concatenate([f.points()[f.depth_m > 0][::16] for f in frames])
    heights = points @ up
    counts, edges = np.histogram(heights, bins=np.arange(heights.min(), heights.max(), 0.05))
    lowest = int(np.argmax(counts > 0.1 * counts.max()))
    near = np.abs(heights - edges[lowest : lowest + 2].mean()) < 0.06
    for _ in range(3):  # refit on the plane's own inliers
        centre = points[near].mean(axis=0)
        normal = np.linalg.svd(points[near] - centre, full_matrices=False)[2][2]
        normal *= np.sign(normal @ up)
        near = np.abs((points - centre) @ normal) < 0.03
    return Plane(normal, float(normal @ centre))


@dataclass(frozen=True)
class FloorMap:
    """Cells of the floor: uint8 (rows, columns), NEVER_SEEN, FREE or OCCUPIED."""

    plane: Plane
    cells: NDArray[np.uint8]
    origin_m: NDArray[np.float64]
    cell_m: float

    def project(self, frame: Frame) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """The map as a frame's camera sees it, everything else removed.

        Returns:
            The cell that each pixel's ray meets, uint8 (H, W), and the distance to it along the
            optical axis, float32 (H, W), metres; 0 where the ray meets no floor.
        """
        depth_m = frame.depth_to_m(self.plane)
        points = replace(frame, depth_m=depth_m.astype(np.float32)).points()
        rows, columns = _cell_indices(points, self.plane, self.origin_m, self.cell_m)
        inside = (depth_m > 0) & (rows >= 0) & (columns >= 0)
        inside &= (rows < self.cells.shape[0]) & (columns < self.cells.shape[1])
        cells = np.zeros(depth_m.shape, np.uint8)
        cells[inside] = self.cells[rows[inside], columns[inside]]
        return cells, depth_m.astype(np.float32)


def build_floor_map(frames: list[Frame], plane: Plane, cell_m: float = 0.04) -> FloorMap:
    """Aggregate a clip.

    A cell is free where floor was seen in it and more often than something standing on it (a table
    top above it takes nothing away); occupied where only obstacles were seen; else never seen.
    """
    floor, low, body = [], [], []
    for frame in frames:
        valid = (frame.depth_m > 0.1) & (frame.depth_m < 8)
        points = frame.points()[valid]
        height_m = plane.height_m(points)
        floor.append(points[np.abs(height_m) < FLOOR_HEIGHT_M])
        low.append(points[(height_m >= 0.08) & (height_m < LOW_M)])
        body.append(points[(height_m >= LOW_M) & (height_m < BODY_M)])
    everything = np.concatenate(floor + low + body)
    axes = np.stack(plane.axes())
    flat = everything @ axes.T
    origin_m = flat.min(axis=0) - cell_m
    shape = tuple(np.ceil((flat.max(axis=0) - origin_m) / cell_m).astype(int) + 1)

    def count(points: list[NDArray[np.float64]]) -> NDArray[np.float64]:
        rows, columns = _cell_indices(np.concatenate(points), plane, origin_m, cell_m)
        flat_index = np.ravel_multi_index((rows, columns), shape)
        return np.bincount(flat_index, minlength=shape[0] * shape[1]).reshape(shape)

    floor_hits, low_hits, body_hits = count(floor), count(low), count(body)
    cells = np.full(shape, NEVER_SEEN, np.uint8)
    cells[(low_hits > 2) | (body_hits > 2)] = OCCUPIED
    free = (floor_hits > 2) & (floor_hits > low_hits)
    cells[free] = FREE
    # A sparse sensor leaves pinholes in well-seen floor; a closing of two cells fills them.
    closed = cv2.morphologyEx(free.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
    cells[(closed > 0) & (cells == NEVER_SEEN)] = FREE
    return FloorMap(plane, cells, origin_m, cell_m)


def _cell_indices(
    points: NDArray[np.floating], plane: Plane, origin_m: NDArray[np.float64], cell_m: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    first, second = plane.axes()
    with np.errstate(invalid="ignore"):
        rows = np.floor((points @ first - origin_m[0]) / cell_m).astype(np.int64)
        columns = np.floor((points @ second - origin_m[1]) / cell_m).astype(np.int64)
    return rows, columns
