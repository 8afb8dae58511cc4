"""Synthetic scenes: exact ground truth, with exact boxes and voxels in the test split.

Ground more than a metre behind a wall or a house is not scored: it cannot be inferred from the
image.
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
    """The scenes of a folder that ``fp-train scenes`` wrote.

    Raises:
        SceneFilesError: another version wrote the folder, or it is damaged.
    """
    from footprints_edge_models.scenes.storage.files import scene_names

    boxes = _boxes(folder / "boxes.json")
    for name in scene_names(folder):
        files = (
            folder / "scenes.json",
            folder / "truth" / f"{name}.npz",
            folder / "boxes.json",
            _voxel_file(folder, name),
        )
        yield Item(name, partial(_load, folder, name, boxes.get(name)), files)


def views_of_scenes(folder: Path) -> int:
    """How many pictures of a scene a folder has at most.

    Raises:
        SceneFilesError: another version wrote the folder, or it is damaged.
    """
    from footprints_edge_models.scenes.storage.files import read_settings

    return read_settings(folder).views


def _load(folder: Path, name: str, boxes: tuple[Box, ...] | None) -> GroundTruth:
    from footprints_edge_models.data.readers.synthetic_scenes import MOST_BEHIND_WALL_M
    from footprints_edge_models.scenes.ground_truth.pixels import (
        BEHIND_WALL,
        FOOTPRINT,
        GROUND_ANYWHERE,
        VISIBLE_GROUND,
    )
    from footprints_edge_models.scenes.storage.files import read_scene

    scene = read_scene(folder, name)
    bits, exact = scene.ground_truth.bits, scene.ground_truth
    behind_m = exact.ground_depth_m - exact.visible_depth_m
    valid = ~((bits & BEHIND_WALL > 0) & (behind_m > MOST_BEHIND_WALL_M))
    visible, ground = bits & VISIBLE_GROUND > 0, bits & GROUND_ANYWHERE > 0
    return GroundTruth(
        folder / "images" / f"{name}.jpg",
        (bits.shape[0], bits.shape[1]),
        scene.intrinsics,
        visible_ground=LabelledMask(visible, np.ones(bits.shape, bool)),
        ground=LabelledMask(ground & valid, valid),
        visible_depth_m=exact.visible_depth_m,
        ground_depth_m=np.where(ground & valid, exact.ground_depth_m, 0).astype(np.float32),
        region=convex_hull(visible),
        footprints=(bits & FOOTPRINT > 0) & valid,
        boxes=boxes,
        voxels=_voxels(_voxel_file(folder, name)),
    )


def _boxes(path: Path) -> dict[str, tuple[Box, ...]]:
    """Boxes by scene. The file names the folder too, as it was called when it was written."""
    if not path.is_file():
        return {}
    return {name.rpartition("/")[2]: boxes for name, boxes in read_boxes(path).items()}


def _voxel_file(folder: Path, name: str) -> Path:
    return folder / "voxels" / f"{name}.npz"


def _voxels(path: Path) -> VoxelGrid | None:
    return read_voxels(path) if path.is_file() else None
