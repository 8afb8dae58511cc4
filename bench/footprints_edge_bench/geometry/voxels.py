"""Voxel grids with semantic labels, as SSCNet predicts them, and their floor seen by a camera."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.types import Floats, Mask, Size
from footprints_edge.geometry.camera import Intrinsics, rays

CLASSES = (
    *("empty", "ceiling", "floor", "wall", "window", "chair", "bed", "sofa", "table", "tvs"),
    *("furniture", "objects"),
)
"""SSCNet's classes in its order; the default where a file names no classes."""
PROJECTED_DOWN = frozenset({"chair", "bed", "sofa", "table", "tv", "tvs"})
"""Classes that the paper's SSCNet+ projects to the floor."""


class VoxelsError(FootprintsError):
    """A voxel file is missing or malformed."""


@dataclass(frozen=True, eq=False)
class VoxelGrid:
    """Labelled voxels.

    Attributes:
        labels: uint8 (X, Y, Z), class ids; the third axis points up.
        origin_m: (3,), the corner of voxel (0, 0, 0), in the grid's axes.
        voxel_m: length of a voxel's edge, metres.
        camera_to_grid: (4, 4), from camera axes (x right, y down, z forward) to the grid's, metres.
        class_names: name of each class id.
    """

    labels: NDArray[np.uint8]
    origin_m: NDArray[np.float64]
    voxel_m: float
    camera_to_grid: NDArray[np.float64]
    class_names: tuple[str, ...] = CLASSES

    def floor(self, intrinsics: Intrinsics, size: Size) -> tuple[Floats, Mask]:
        """The floor voxels as a camera would see them with everything else removed.

        Objects in front hide nothing: "voxels estimated as `floor' are reprojected into the
        camera" (paper, "Voxel prediction").

        Returns:
            Depth along the optical axis at which each ray first enters a floor voxel, float32
            (H, W), metres, accurate to half a voxel, infinite where it enters none. And a mask,
            bool (H, W), of rays whose floor voxel has nothing of ``PROJECTED_DOWN`` in its column:
            the floor that remains in the paper's SSCNet+.
        """
        is_floor = self._is({"floor"})
        depth_m = np.full(size[0] * size[1], np.inf, np.float32)
        clear = np.zeros(depth_m.shape, bool)
        if not is_floor.any():
            return depth_m.reshape(size), clear.reshape(size)
        covered: Mask = np.any(self._is(PROJECTED_DOWN), axis=2)
        # In units of voxels: the camera's position, and how far a ray moves per metre of depth.
        start = (self.camera_to_grid[:3, 3] - self.origin_m) / self.voxel_m
        steps = rays(intrinsics, size).reshape(-1, 3) @ self.camera_to_grid[:3, :3].T / self.voxel_m
        enter_m, leave_m = _between(start, steps, is_floor)
        pixels = np.flatnonzero(enter_m < leave_m)
        at_m, last_m = enter_m[pixels], leave_m[pixels]
        stride_m = 0.5 / np.linalg.norm(steps[pixels], axis=1)
        while pixels.size:
            voxel = np.floor(start + steps[pixels] * at_m[:, None]).astype(np.int64)
            x, y, z = np.clip(voxel, 0, np.array(is_floor.shape) - 1).T
            hit = is_floor[x, y, z]
            depth_m[pixels[hit]] = at_m[hit]
            clear[pixels[hit]] = ~covered[x[hit], y[hit]]
            at_m = at_m + stride_m
            on = ~hit & (at_m < last_m)
            pixels, at_m, last_m, stride_m = pixels[on], at_m[on], last_m[on], stride_m[on]
        return depth_m.reshape(size), clear.reshape(size)

    def _is(self, names: frozenset[str] | set[str]) -> Mask:
        ids = [i for i, name in enumerate(self.class_names) if name in names]
        mask: Mask = np.isin(self.labels, ids)
        return mask


def _between(
    start: NDArray[np.float64], steps: NDArray[np.float64], is_floor: Mask
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Depths, metres, at which each ray enters and leaves the bounding box of all floor voxels."""
    occupied = np.nonzero(is_floor)
    low = np.array([axis.min() for axis in occupied])
    high = np.array([axis.max() + 1 for axis in occupied])
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (low - start) / steps, (high - start) / steps
    enter = np.nanmax(np.minimum(first, second), axis=1)
    leave = np.nanmin(np.maximum(first, second), axis=1)
    return np.maximum(enter, 0) + 1e-9, leave


def read_voxels(path: Path) -> VoxelGrid:
    """A grid from an npz file with the attributes of :class:`VoxelGrid`; class_names is optional.

    Raises:
        VoxelsError: the file is missing or malformed.
    """
    try:
        with np.load(path) as arrays:
            names = arrays.get("class_names", CLASSES)
            grid = VoxelGrid(
                arrays["labels"].astype(np.uint8),
                arrays["origin_m"].astype(np.float64),
                float(arrays["voxel_m"]),
                arrays["camera_to_grid"].astype(np.float64),
                tuple(str(name) for name in names),
            )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise VoxelsError(
            f"{path}: cannot read voxels ({type(error).__name__}: {error}); give labels (X, Y, Z), "
            "origin_m, voxel_m and camera_to_grid (docs/accuracy.md)"
        ) from error
    shapes = (grid.labels.ndim, grid.origin_m.shape, grid.camera_to_grid.shape)
    if shapes != (3, (3,), (4, 4)) or not grid.voxel_m > 0 or "floor" not in grid.class_names:
        raise VoxelsError(
            f"{path}: labels have {shapes[0]} axes, origin_m is {shapes[1]}, camera_to_grid "
            f"{shapes[2]}, voxel_m {grid.voxel_m:g}, classes {', '.join(grid.class_names)}; give "
            "3 axes, (3,), (4, 4), a length, and a class named floor"
        )
    return grid
