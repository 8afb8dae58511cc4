"""A room painted in the colours that the tiny model reads as maps, as a perfect network would.

No weights have a part in it, so what its test vectors must hold can be stated, and every port must
give it to the last digits.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image
from tiny_metadata import TINY
from tiny_model import tiny_model_bytes

import footprints_edge as fp
from footprints_edge.geometry.camera import Intrinsics

SIZE = (540, 960)
HEIGHT_M, PITCH_DEG = 1.4, 8.0
NEAREST_M, FARTHEST_M = 1.0, 100.0


def painted_model(path: Path) -> Path:
    """The model whose maps are the picture's colours, with a scale on which a room has depth."""
    metadata = replace(TINY, depth_range_m=(NEAREST_M, FARTHEST_M))
    path.write_bytes(tiny_model_bytes(metadata=metadata))
    return path


def painted_photo(path: Path) -> Path:
    """A floor up to a wall, a box that hides some of it, and a thin kerb across the floor.

    Green is visible ground and red hidden ground; blue is disparity, twice the ground's.
    """
    camera = Intrinsics.assumed(SIZE)
    pitch = np.radians(PITCH_DEG)
    v, u = np.indices(SIZE)
    across, down = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    fall = down * np.cos(pitch) + np.sin(pitch)  # of a ray of depth 1, in metres
    depth_m = HEIGHT_M / np.maximum(fall, 1e-6)
    ahead_m = depth_m * (np.cos(pitch) - down * np.sin(pitch))
    left_m = -across * depth_m

    wall_m = 6.0
    is_floor = (fall > 1e-6) & (ahead_m < wall_m)
    depth_m = np.where(is_floor, depth_m, wall_m)
    on_box = (np.abs(u - 700) < 100) & (v > 240) & (v < 400)
    depth_m = np.where(on_box, depth_m[400, 700], depth_m)
    kerb = is_floor & ~on_box & (np.abs(left_m + ahead_m - 2.2) < 0.03) & (ahead_m < 4.5)

    red, green = on_box & is_floor, is_floor & ~on_box & ~kerb
    disparity = (1 / depth_m - 1 / FARTHEST_M) / (1 / NEAREST_M - 1 / FARTHEST_M)
    rgb = np.stack([255.0 * red, 255.0 * green, 510 * disparity], axis=-1)
    Image.fromarray(np.rint(rgb).clip(0, 255).astype(np.uint8)).save(path)
    return path


def painted(folder: Path) -> tuple[fp.Model, Path]:
    """The model and the photo."""
    file = painted_model(folder / "painted.onnx")
    return fp.load(file, threads=1), painted_photo(folder / "painted.png")
