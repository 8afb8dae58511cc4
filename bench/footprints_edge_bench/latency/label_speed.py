"""Training labels at 256x448 with 10 neighbours, on one core, beside a plain loop over pixels.

    python -m footprints_edge_bench.label_speed

Both make the label of eq. 1 and 2 and the untraversable pixels of a made-up room: a floor, a
wall and a crate, seen from eleven places. The loop does with Python's numbers, pixel after
pixel, what the formulas say; the two labels are compared before any figure is printed.
"""

import itertools
import json
import math
import statistics
import sys
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics

SIZE = (256, 448)
CAMERA = Intrinsics(400, 400, 223.5, 127.5)
NEIGHBOURS = 10
LEAST_HITS = 2
HEIGHT_M = 1.5
CRATE = ((-0.4, 6.0), (0.5, 6.6), 0.9)
"""From and to (x, z), and its height, metres."""
WALL_M = 12.0

Depth = NDArray[np.float32]


def room(x_m: float) -> tuple[Depth, Depth]:
    """Depth and ground (H, W) of a level camera 1.5 m above the floor that stands at x = x_m."""
    rows, columns = np.mgrid[: SIZE[0], : SIZE[1]]
    across, down = (columns - CAMERA.cx) / CAMERA.fx, (rows - CAMERA.cy) / CAMERA.fy
    with np.errstate(divide="ignore", invalid="ignore"):
        floor_m = np.where(down > 0, HEIGHT_M / down, np.inf)
        (x0, z0), (x1, z1), top_m = CRATE
        enters, leaves = np.full(SIZE, z0), np.full(SIZE, z1)
        for slope, low, high in ((across, x0 - x_m, x1 - x_m), (down, HEIGHT_M - top_m, HEIGHT_M)):
            enters = np.maximum(enters, np.minimum(low / slope, high / slope))
            leaves = np.minimum(leaves, np.maximum(low / slope, high / slope))
    crate_m = np.where((enters < leaves) & (leaves > 0), enters, np.inf)
    depth_m = np.minimum(np.minimum(floor_m, crate_m), WALL_M)
    return depth_m.astype(np.float32), (depth_m == floor_m).astype(np.float32)


def by_arrays(
    frames: list[tuple[Depth, Depth]], poses: list[NDArray[np.float64]]
) -> tuple[Depth, NDArray[np.bool_]]:
    """The labels of the last frame, as `fp-train labels` makes them."""
    from footprints_edge_models.video_labels.footprint_masks import footprint_pixels
    from footprints_edge_models.video_labels.warping import aggregate, warp_depth

    warped = [
        warp_depth(depth_m * ground, CAMERA, CAMERA, pose, SIZE)
        for (depth_m, ground), pose in zip(frames[:-1], poses, strict=True)
    ]
    return aggregate(np.stack(warped), LEAST_HITS), footprint_pixels(*frames[-1], CAMERA)


def by_pixels(
    frames: list[tuple[Depth, Depth]], poses: list[NDArray[np.float64]]
) -> tuple[Depth, NDArray[np.bool_]]:
    """The same, one pixel after the other."""
    landed = [
        land(depth_m.tolist(), ground.tolist(), pose.tolist())
        for (depth_m, ground), pose in zip(frames[:-1], poses, strict=True)
    ]
    ground_m = np.zeros(SIZE, np.float32)
    for pixel in range(ground_m.size):
        depths_m = [hits[pixel] for hits in landed if pixel in hits]
        if len(depths_m) > LEAST_HITS:
            ground_m.flat[pixel] = statistics.median(depths_m)
    depth_m, ground = frames[-1]
    return ground_m, splat(depth_m.tolist(), ground.tolist())


def land(
    depths_m: list[list[float]], grounds: list[list[float]], pose: list[list[float]]
) -> dict[int, float]:
    """Where one neighbour's ground falls: depth by pixel."""
    hits: dict[int, float] = {}
    for row in range(SIZE[0]):
        for column in range(SIZE[1]):
            depth_m = depths_m[row][column]
            if depth_m > 0 and grounds[row][column] > 0.75:
                x = (column - CAMERA.cx) / CAMERA.fx * depth_m
                y = (row - CAMERA.cy) / CAMERA.fy * depth_m
                x, y, z = (r[0] * x + r[1] * y + r[2] * depth_m + r[3] for r in pose[:3])
                pixel = pixel_of(x, y, z)
                if pixel is not None:
                    hits[pixel] = min(z, hits.get(pixel, math.inf))
    return hits


def splat(depths_m: list[list[float]], grounds: list[list[float]]) -> NDArray[np.bool_]:
    """Untraversable pixels. The camera is level: its plane is y = HEIGHT_M, along x and z."""
    found = np.zeros(SIZE, bool)
    steps_m = [0.025 * step for step in range(-4, 4)]
    for row in range(SIZE[0]):
        for column in range(SIZE[1]):
            depth_m = depths_m[row][column]
            if depth_m <= 0 or grounds[row][column] > 0.75:
                continue
            x = (column - CAMERA.cx) / CAMERA.fx * depth_m
            for aside_m, ahead_m in itertools.product(steps_m, steps_m):
                foot_m = depth_m + ahead_m
                pixel = pixel_of(x + aside_m, HEIGHT_M, foot_m)
                if pixel is not None:
                    j, i = divmod(pixel, SIZE[1])
                    if grounds[j][i] < 0.5 and abs(foot_m - depths_m[j][i]) < 0.1 * depths_m[j][i]:
                        found[j, i] = True
    return found


def pixel_of(x: float, y: float, z: float) -> int | None:
    """Row-major index of the pixel that shows a point, None beside the picture."""
    if z <= 0:
        return None
    column = math.floor(CAMERA.fx * x / z + CAMERA.cx + 0.5)
    row = math.floor(CAMERA.fy * y / z + CAMERA.cy + 0.5)
    inside = 0 <= row < SIZE[0] and 0 <= column < SIZE[1]
    return row * SIZE[1] + column if inside else None


def main() -> None:
    """Print frames a second of both and their ratio as JSON."""
    import cv2

    cv2.setNumThreads(1)
    places = [*np.linspace(-1.5, 1.5, NEIGHBOURS), 0.0]
    frames = [room(x_m) for x_m in places]
    poses = []
    for x_m in places[:-1]:
        pose = np.eye(4)
        pose[0, 3] = x_m
        poses.append(pose)
    ground_m, untraversable = by_arrays(frames, poses)
    times_s = []
    for _ in range(10):
        start = perf_counter()
        by_arrays(frames, poses)
        times_s.append(perf_counter() - start)
    start = perf_counter()
    plain_m, plain = by_pixels(frames, poses)
    loop_s = perf_counter() - start
    result = {
        "size": SIZE,
        "neighbours": NEIGHBOURS,
        "same_ground_pixels": float(((ground_m > 0) == (plain_m > 0)).mean()),
        "largest_difference_m": float(np.abs(ground_m - plain_m)[plain_m > 0].max()),
        "untraversable_iou": float((untraversable & plain).sum() / (untraversable | plain).sum()),
        "arrays_frames_per_s_core": 1 / statistics.median(times_s),
        "loop_frames_per_s_core": 1 / loop_s,
        "ratio": loop_s / statistics.median(times_s),
        "numpy": np.__version__,
    }
    sys.stdout.write(json.dumps(result, indent=2) + "\n")


if __name__ == "__main__":
    main()
