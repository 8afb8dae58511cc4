"""Made scenes as training samples, decoded when they are drawn: ten thousands take no memory."""

from collections.abc import Sequence
from pathlib import Path
from typing import overload

import numpy as np

from footprints_edge_models.sample import NO, TAKEN, UNSEEN, YES, Sample
from footprints_edge_models.scenes.ground_truth.pixels import (
    BEHIND_WALL,
    FOOTPRINT,
    GROUND_ANYWHERE,
    VISIBLE_GROUND,
)
from footprints_edge_models.scenes.storage.files import (
    SceneFilesError,
    read_scene,
    read_settings,
    scene_names,
)

MOST_BEHIND_WALL_M = 1.0
"""Ground farther than this behind a wall or a house cannot be told from the picture: there it is
held as the paper holds what no frame saw (eq. 3c), nor is its depth taught."""


class MadeScenes(Sequence[Sample]):
    """The scenes of a folder, or some of them."""

    def __init__(self, folder: Path, names: Sequence[str]) -> None:
        self.folder = folder
        self.names = tuple(names)

    def __len__(self) -> int:
        """How many there are."""
        return len(self.names)

    @overload
    def __getitem__(self, index: int) -> Sample: ...

    @overload
    def __getitem__(self, index: slice) -> "MadeScenes": ...

    def __getitem__(self, index: int | slice) -> "Sample | MadeScenes":
        """One scene, read from its files; or some, unread."""
        if isinstance(index, slice):
            return MadeScenes(self.folder, self.names[index])
        return read_sample(self.folder, self.names[index])


def read_scenes(folder: Path) -> MadeScenes:
    """The scenes of a folder, to train on.

    Raises:
        SceneFilesError: it holds no scenes, or those of the test split.
    """
    settings = read_settings(folder)
    if settings.split != "train":
        raise SceneFilesError(f"{folder}: scenes of the {settings.split} split; train on others")
    return MadeScenes(folder, scene_names(folder))


def read_sample(folder: Path, name: str) -> Sample:
    """A scene as a training sample: everything is known but what lies far behind walls.

    Raises:
        SceneFilesError: it is missing or damaged.
    """
    made = read_scene(folder, name)
    truth = made.ground_truth
    ground = np.where(truth.bits & GROUND_ANYWHERE > 0, YES, NO).astype(np.uint8)
    ground[truth.bits & FOOTPRINT > 0] = TAKEN
    gap_m = truth.ground_depth_m - truth.visible_depth_m
    ground[(truth.bits & BEHIND_WALL > 0) & (gap_m > MOST_BEHIND_WALL_M)] = UNSEEN
    return Sample(
        f"{folder.name}/{name}",
        made.image,
        made.intrinsics,
        np.where(truth.bits & VISIBLE_GROUND > 0, YES, NO).astype(np.uint8),
        ground,
        truth.visible_depth_m.astype(np.float16),
        np.where(ground == YES, truth.ground_depth_m, 0).astype(np.float16),
    )
