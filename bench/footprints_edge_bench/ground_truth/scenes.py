"""Ground truth of synthetic scenes: exact, with the true boxes and voxels of their test split.

Ground behind a wall or a house, more than a metre beyond it, is not scored: no picture tells what
is there.
"""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from footprints_edge_bench.geometry.boxes import Box, read_boxes
from footprints_edge_bench.geometry.convex_hull import convex_hull
from footprints_edge_bench.geometry.voxels import VoxelGrid, read_voxels
from footprints_edge_bench.ground_truth.base import GroundTruth, Item, LabelledMask


def is_scene_folder(folder: Path) -> bool:
    """Whether a folder holds synthetic scenes."""
    return (folder / "scenes.json").is_file()


def read_scenes(folder: Path) -> Iterator[Item]:
    """The scenes of a folder that ``fp-train scenes`` made.

    Raises:
        SceneFilesError: it was made by another version, or is damaged.
    """
    from footprints_edge_models.scenes.storage.files import scene_names

    boxes = read_boxes(folder / "boxes.json") if (folder / "boxes.json").is_file() else {}
    for name in scene_names(folder):
        yield Item(name, partial(_load, folder, name, boxes.get(f"{folder.resolve().name}/{name}")))


def _load(folder: Path, name: str, boxes: tuple[Box, ...] | None) -> GroundTruth:
    from footprints_edge_models.scenes.ground_truth.truth import (
        BEHIND_WALL,
        GROUND_ANYWHERE,
        VISIBLE_GROUND,
    )
    from footprints_edge_models.scenes.storage.dataset import MOST_BEHIND_WALL_M
    from footprints_edge_models.scenes.storage.files import read_scene

    scene = read_scene(folder, name)
    bits, truth = scene.truth.bits, scene.truth
    behind_m = truth.ground_depth_m - truth.visible_depth_m
    known = ~((bits & BEHIND_WALL > 0) & (behind_m > MOST_BEHIND_WALL_M))
    visible, ground = bits & VISIBLE_GROUND > 0, bits & GROUND_ANYWHERE > 0
    return GroundTruth(
        folder / "images" / f"{name}.jpg",
        (bits.shape[0], bits.shape[1]),
        scene.intrinsics,
        LabelledMask(visible, np.ones(bits.shape, bool)),
        LabelledMask(ground & known, known),
        truth.visible_depth_m,
        np.where(ground & known, truth.ground_depth_m, 0).astype(np.float32),
        convex_hull(visible),
        boxes,
        _voxels(folder / "voxels" / f"{name}.npz"),
    )


def _voxels(path: Path) -> VoxelGrid | None:
    return read_voxels(path) if path.is_file() else None
