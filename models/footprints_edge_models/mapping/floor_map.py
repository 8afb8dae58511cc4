"""The floor map of a clip, in bird's-eye view: which cells are free, occupied or unknown.

Every frame's depth is lifted into the world and sorted by height above the floor. The map,
projected into a frame, is the frame's ground, seen or hidden ("a top-down floor map reprojected
into the camera view", paper, section "Our Footprints world model").
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics, backproject, rays
from footprints_edge_models.mapping.planes import Plane
from footprints_edge_models.sample import NO, UNKNOWN, YES

NEVER_SEEN, FREE, OCCUPIED, OVERHUNG = 0, 1, 2, 3
"""States of a cell. OVERHUNG: something, a table top, say, was seen above it, and nothing below."""

FLOOR_HEIGHT_M = 0.05
"""Points nearer to the plane than this are floor."""
LOW_M, BODY_M = 0.35, 1.8
"""Obstacles up to LOW_M stand on the floor; above BODY_M a person passes beneath."""


@dataclass(frozen=True)
class DepthFrame:
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


def fit_floor(frames: Iterable[DepthFrame], up: NDArray[np.float64]) -> Plane:
    """Fit the lowest well-filled horizontal plane of a clip.

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
        plane = Plane.through(points[near]).facing(up)
        near = np.abs(plane.height_m(points)) < 0.03
    return plane


def ground_by_depth(
    frame: DepthFrame, plane: Plane, tolerance_m: float | NDArray[np.float32] = FLOOR_HEIGHT_M
) -> NDArray[np.uint8]:
    """Visible ground by measured depth.

    Returns:
        uint8 (H, W): YES within ``tolerance_m`` of the plane, NO elsewhere, UNKNOWN without depth
        and on the floor's borders.
    """
    height_m = np.abs(plane.height_m(frame.points()))
    visible = np.where(height_m < tolerance_m, YES, NO).astype(np.uint8)
    visible[frame.depth_m <= 0] = UNKNOWN
    # Colour and depth are some pixels apart, so borders of the floor have no label.
    kernel = np.ones((3, 3), np.uint8)
    is_ground, is_other = (visible == YES).astype(np.uint8), (visible == NO).astype(np.uint8)
    border = cv2.dilate(is_ground, kernel) & cv2.dilate(is_other, kernel)
    visible[border > 0] = UNKNOWN
    return visible


@dataclass(frozen=True)
class FloorMap:
    """Cells of the floor: uint8 (rows, columns), NEVER_SEEN, FREE, OCCUPIED or OVERHUNG."""

    plane: Plane
    cells: NDArray[np.uint8]
    origin_m: NDArray[np.float64]
    cell_m: float

    def project(self, frame: DepthFrame) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Project the map into a frame, as if nothing stood on the floor.

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


def build_floor_map(frames: list[DepthFrame], plane: Plane, cell_m: float = 0.04) -> FloorMap:
    """Build the floor map of a clip.

    A cell is free where floor was seen in it and more often than something standing on it (a table
    top above it takes nothing away); occupied where something low was seen, or something higher
    that borders on it, as the inside of a counter does; overhung where something higher was seen
    that has floor around it, as a table top does; else never seen.
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
    free = (floor_hits > 2) & (floor_hits > low_hits)
    standing = low_hits > 2
    above = (body_hits > 2) & ~standing
    # A sparse sensor leaves pinholes in well-seen floor: a closing of two cells fills them. Floor
    # narrower than three cells, inside a wall or a sofa, is depth noise: an opening removes it.
    closed = _morphology(free, cv2.MORPH_CLOSE, 5) & ~standing & ~above
    free = _morphology(free | closed, cv2.MORPH_OPEN, 3)
    above &= ~free
    cells = np.full(shape, NEVER_SEEN, np.uint8)
    cells[standing | above] = OCCUPIED
    cells[_hanging(above, free & ~standing, standing)] = OVERHUNG
    cells[free] = FREE
    return FloorMap(plane, cells, origin_m, cell_m)


def _morphology(mask: NDArray[np.bool_], operation: int, side: int) -> NDArray[np.bool_]:
    kernel = np.ones((side, side), np.uint8)
    changed: NDArray[np.bool_] = cv2.morphologyEx(mask.astype(np.uint8), operation, kernel) > 0
    return changed


def _hanging(
    above: NDArray[np.bool_], free: NDArray[np.bool_], standing: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Connected regions of ``above`` that do not border on more standing things than floor."""
    count, regions = cv2.connectedComponents(above.astype(np.uint8), connectivity=4)
    reach = cv2.dilate(regions.astype(np.float32), np.ones((3, 3), np.uint8)).astype(np.int64)
    borders_free = np.bincount(reach[free], minlength=count)
    borders_standing = np.bincount(reach[standing], minlength=count)
    hanging: NDArray[np.bool_] = above & (borders_standing <= borders_free)[regions]
    return hanging


def _cell_indices(
    points: NDArray[np.floating], plane: Plane, origin_m: NDArray[np.float64], cell_m: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    first, second = plane.axes()
    with np.errstate(invalid="ignore"):
        rows = np.floor((points @ first - origin_m[0]) / cell_m).astype(np.int64)
        columns = np.floor((points @ second - origin_m[1]) / cell_m).astype(np.int64)
    return rows, columns
