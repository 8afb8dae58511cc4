"""Speed of training labels against a plain loop over pixels, on one core.

Both compute the labels of equations 1 and 2 and the footprint mask for a synthetic room with a
floor, a wall and a crate, at 256x448 with 10 neighbouring frames. The loop applies the formulas to
Python numbers, pixel by pixel. The report says how well the labels of both agree.
"""

import itertools
import json
import math
import statistics
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Floats, Mask, Size
from footprints_edge.geometry.camera import Intrinsics

NEIGHBOURS = 10
LEAST_HITS = 2
HEIGHT_M = 1.5
CRATE = ((-0.4, 6.0), (0.5, 6.6), 0.9)
"""Two corners (x, z) and the height of the crate, metres."""
WALL_M = 12.0

Frame = tuple[Floats, Floats]
"""Depth, metres, and probability of ground, both (H, W)."""


@dataclass(frozen=True)
class LabelCamera:
    """A level camera.

    Attributes:
        size: (H, W) of its images.
        intrinsics: in pixels of the images.
    """

    size: Size
    intrinsics: Intrinsics

    def pixel_of(self, x: float, y: float, z: float) -> int | None:
        """Row-major index of the pixel that shows a point; None outside the image."""
        if z <= 0:
            return None
        column = math.floor(self.intrinsics.fx * x / z + self.intrinsics.cx + 0.5)
        row = math.floor(self.intrinsics.fy * y / z + self.intrinsics.cy + 0.5)
        inside = 0 <= row < self.size[0] and 0 <= column < self.size[1]
        return row * self.size[1] + column if inside else None


CAMERA = LabelCamera((256, 448), Intrinsics(400, 400, 223.5, 127.5))


@dataclass(frozen=True)
class LabelSpeed:
    """Speed and agreement of both ways to compute labels.

    Attributes:
        size: (H, W) of the labels.
        neighbours: number of frames that are warped into the labelled one.
        same_ground_pixels: share of pixels that both label alike as ground or not.
        largest_difference_m: largest difference of the ground depth, metres.
        footprint_iou: IoU of both footprint masks.
        arrays_frames_per_s_core: labelled frames per second and core, as ``fp-train labels`` does.
        loop_frames_per_s_core: the same for the plain loop.
        ratio: speed-up over the plain loop.
        numpy: version of numpy.
    """

    size: Size
    neighbours: int
    same_ground_pixels: float
    largest_difference_m: float
    footprint_iou: float
    arrays_frames_per_s_core: float
    loop_frames_per_s_core: float
    ratio: float
    numpy: str

    def as_json(self) -> str:
        """All values."""
        return json.dumps(asdict(self), indent=2) + "\n"


def measure_label_speed(camera: LabelCamera = CAMERA, trials: int = 10) -> LabelSpeed:
    """Computes labels both ways, and times them.

    Args:
        camera: camera of the labels.
        trials: timed runs of the array code; the loop runs once.
    """
    import cv2

    cv2.setNumThreads(1)
    places_m = [*np.linspace(-1.5, 1.5, NEIGHBOURS), 0.0]
    frames = [room(camera, x_m) for x_m in places_m]
    poses = [_pose(x_m) for x_m in places_m[:-1]]
    ground_m, footprints = labels_by_arrays(camera, frames, poses)
    times_s = []
    for _ in range(trials):
        start_s = perf_counter()
        labels_by_arrays(camera, frames, poses)
        times_s.append(perf_counter() - start_s)
    start_s = perf_counter()
    loop_ground_m, loop_footprints = labels_by_loop(camera, frames, poses)
    loop_s = perf_counter() - start_s
    arrays_s = statistics.median(times_s)
    difference_m = np.abs(ground_m - loop_ground_m)[loop_ground_m > 0]
    overlap, union = footprints & loop_footprints, footprints | loop_footprints
    return LabelSpeed(
        size=camera.size,
        neighbours=NEIGHBOURS,
        same_ground_pixels=float(((ground_m > 0) == (loop_ground_m > 0)).mean()),
        largest_difference_m=float(difference_m.max()),
        footprint_iou=float(overlap.sum() / union.sum()),
        arrays_frames_per_s_core=1 / arrays_s,
        loop_frames_per_s_core=1 / loop_s,
        ratio=loop_s / arrays_s,
        numpy=np.__version__,
    )


def room(camera: LabelCamera, x_m: float) -> Frame:
    """What the camera sees of the room from x = x_m, 1.5 m above the floor."""
    rows, columns = np.mgrid[: camera.size[0], : camera.size[1]]
    intrinsics = camera.intrinsics
    across = (columns - intrinsics.cx) / intrinsics.fx
    down = (rows - intrinsics.cy) / intrinsics.fy
    with np.errstate(divide="ignore", invalid="ignore"):
        floor_m = np.where(down > 0, HEIGHT_M / down, np.inf)
        (x0, z0), (x1, z1), top_m = CRATE
        enters, leaves = np.full(camera.size, z0), np.full(camera.size, z1)
        for slope, low, high in ((across, x0 - x_m, x1 - x_m), (down, HEIGHT_M - top_m, HEIGHT_M)):
            enters = np.maximum(enters, np.minimum(low / slope, high / slope))
            leaves = np.minimum(leaves, np.maximum(low / slope, high / slope))
    crate_m = np.where((enters < leaves) & (leaves > 0), enters, np.inf)
    depth_m = np.minimum(np.minimum(floor_m, crate_m), WALL_M)
    return depth_m.astype(np.float32), (depth_m == floor_m).astype(np.float32)


def labels_by_arrays(
    camera: LabelCamera, frames: Sequence[Frame], poses: Sequence[NDArray[np.float64]]
) -> tuple[Floats, Mask]:
    """Ground depth, metres, and footprint mask of the last frame, as `fp-train labels` does."""
    from footprints_edge_models.video_labels.footprint_masks import footprint_pixels
    from footprints_edge_models.video_labels.warping import aggregate, warp_depth

    intrinsics = camera.intrinsics
    warped = [
        warp_depth(depth_m * ground, intrinsics, intrinsics, pose, camera.size)
        for (depth_m, ground), pose in zip(frames[:-1], poses, strict=True)
    ]
    footprints = footprint_pixels(*frames[-1], intrinsics)
    return aggregate(np.stack(warped), LEAST_HITS), footprints


def labels_by_loop(
    camera: LabelCamera, frames: Sequence[Frame], poses: Sequence[NDArray[np.float64]]
) -> tuple[Floats, Mask]:
    """The same, pixel by pixel."""
    landed = [
        _warp_by_loop(camera, depth_m.tolist(), ground.tolist(), pose.tolist())
        for (depth_m, ground), pose in zip(frames[:-1], poses, strict=True)
    ]
    ground_m = np.zeros(camera.size, np.float32)
    for pixel in range(ground_m.size):
        depths_m = [hits[pixel] for hits in landed if pixel in hits]
        if len(depths_m) > LEAST_HITS:
            ground_m.flat[pixel] = statistics.median(depths_m)
    depth_m, ground = frames[-1]
    return ground_m, _footprints_by_loop(camera, depth_m.tolist(), ground.tolist())


def _pose(x_m: float) -> NDArray[np.float64]:
    """Pose (4, 4) of a camera that is shifted to x = x_m."""
    pose = np.eye(4)
    pose[0, 3] = x_m
    return pose


def _warp_by_loop(
    camera: LabelCamera,
    depths_m: list[list[float]],
    grounds: list[list[float]],
    pose: list[list[float]],
) -> dict[int, float]:
    """Depth, metres, of a neighbour's ground in the labelled frame, by pixel."""
    intrinsics = camera.intrinsics
    hits: dict[int, float] = {}
    for row in range(camera.size[0]):
        for column in range(camera.size[1]):
            depth_m = depths_m[row][column]
            if depth_m > 0 and grounds[row][column] > 0.75:
                x = (column - intrinsics.cx) / intrinsics.fx * depth_m
                y = (row - intrinsics.cy) / intrinsics.fy * depth_m
                x, y, z = (r[0] * x + r[1] * y + r[2] * depth_m + r[3] for r in pose[:3])
                pixel = camera.pixel_of(x, y, z)
                if pixel is not None:
                    hits[pixel] = min(z, hits.get(pixel, math.inf))
    return hits


def _footprints_by_loop(
    camera: LabelCamera, depths_m: list[list[float]], grounds: list[list[float]]
) -> Mask:
    """Footprint mask. Since the camera is level, the ground plane is y = HEIGHT_M."""
    found = np.zeros(camera.size, bool)
    steps_m = [0.025 * step for step in range(-4, 4)]
    for row in range(camera.size[0]):
        for column in range(camera.size[1]):
            depth_m = depths_m[row][column]
            if depth_m <= 0 or grounds[row][column] > 0.75:
                continue
            x = (column - camera.intrinsics.cx) / camera.intrinsics.fx * depth_m
            for aside_m, ahead_m in itertools.product(steps_m, steps_m):
                foot_m = depth_m + ahead_m
                pixel = camera.pixel_of(x + aside_m, HEIGHT_M, foot_m)
                if pixel is not None:
                    j, i = divmod(pixel, camera.size[1])
                    if grounds[j][i] < 0.5 and abs(foot_m - depths_m[j][i]) < 0.1 * depths_m[j][i]:
                        found[j, i] = True
    return found
