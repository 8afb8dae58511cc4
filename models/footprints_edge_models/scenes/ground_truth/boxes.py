"""Exact boxes around the things of a scene, in camera axes."""

from typing import Any

import numpy as np

from footprints_edge_models.scenes.assets.things import Thing
from footprints_edge_models.scenes.layout.scene import Scene
from footprints_edge_models.scenes.rendering.cameras import Camera

FARTHEST_M = 40.0
BODY_M = 1.8
"""A part that begins higher, a tree's crown, say, does not widen a box."""


def boxes_of(scene: Scene, camera: Camera) -> list[dict[str, Any]]:
    """Boxes of what stands in view: ``label``, ``centre_m``, ``size_m`` and ``rotation``.

    The columns of ``rotation`` are a box's axes in camera axes; the second points down. Walls,
    doors and buildings have no box.
    """
    boxes = []
    for thing in scene.things:
        if thing.is_wall or not thing.footprints():
            continue
        low, high = _extent(thing)
        turn = thing.pose[:, :3]
        middle = turn @ ((low + high) / 2) + thing.pose[:, 3]
        middle[2] += float(middle[:2] @ scene.slope)
        centre = camera.rotation.T @ (middle - camera.position_m)
        axes = camera.rotation.T @ np.column_stack([turn[:, 0], -turn[:, 2], turn[:, 1]])
        size = (high - low)[[0, 2, 1]]
        if _in_view(centre, axes, size, camera):
            boxes.append(
                {
                    "label": thing.label,
                    "centre_m": np.round(centre, 4).tolist(),
                    "size_m": np.round(size, 4).tolist(),
                    "rotation": np.round(axes, 7).tolist(),
                }
            )
    return boxes


def _extent(thing: Thing) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    lows, highs = [], []
    for part in thing.parts:
        points = part.shape.outline @ part.matrix[:, :3].T + part.matrix[:, 3]
        low, high = points.min(axis=0), points.max(axis=0)
        lows.append(low)
        highs.append(high)
    low, high = np.array(lows), np.array(highs)
    # things of worlds are in the world's axes: theirs is the floor of a storey, or a kerb
    foot_m = thing.level_m - thing.pose[2, 3] if thing.level_m else 0.0
    near = low[:, 2] < foot_m + BODY_M
    least, most = low[near].min(axis=0), high[near].max(axis=0)
    least[2], most[2] = foot_m, high[:, 2].max()
    return least, most


def _in_view(
    centre: np.ndarray[Any, Any],
    axes: np.ndarray[Any, Any],
    size: np.ndarray[Any, Any],
    camera: Camera,
) -> bool:
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
    corners = centre + (signs * size) @ axes.T
    if corners[:, 2].max() < 0.1 or corners[:, 2].min() > FARTHEST_M:
        return False
    k = camera.intrinsics
    depth = np.maximum(corners[:, 2], 0.1)
    x, y = k.fx * corners[:, 0] / depth + k.cx, k.fy * corners[:, 1] / depth + k.cy
    height, width = camera.size
    return bool(x.max() > 0 and x.min() < width and y.max() > 0 and y.min() < height)
