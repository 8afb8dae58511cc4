"""Synthetic scenes, decoded when they are drawn: tens of thousands take no memory."""

from collections.abc import Sequence
from pathlib import Path
from typing import overload

import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.sample import FOOTPRINT, NO, UNSEEN, YES, Sample
from footprints_edge_models.scenes.ground_truth import pixels
from footprints_edge_models.scenes.ground_truth.pixels import SceneGroundTruth
from footprints_edge_models.scenes.storage.files import (
    SceneFilesError,
    read_scene,
    read_settings,
    scene_names,
)

MOST_BEHIND_WALL_M = 1.0
"""Ground farther than this behind a wall or a house cannot be inferred from the picture. It counts
as ground that no frame saw (paper, eq. 3c), and its depth is not a target."""


class SyntheticScenes(Sequence[Sample]):
    """The scenes of a folder, or some of them.

    Attributes:
        folder: their folder.
        names: of the pictures.
        views: greatest number of pictures of a scene; see ``splits.scenes_cut``.
    """

    def __init__(self, folder: Path, names: Sequence[str], views: int = 1) -> None:
        self.folder = folder
        self.names = tuple(names)
        self.views = views

    def __len__(self) -> int:
        """How many there are."""
        return len(self.names)

    @overload
    def __getitem__(self, index: int) -> Sample: ...

    @overload
    def __getitem__(self, index: slice) -> "SyntheticScenes": ...

    def __getitem__(self, index: int | slice) -> "Sample | SyntheticScenes":
        """One scene, read from its files; or some, unread."""
        if isinstance(index, slice):
            return SyntheticScenes(self.folder, self.names[index], self.views)
        return read_sample(self.folder, self.names[index])


def read_synthetic_scenes(folder: Path) -> SyntheticScenes:
    """The scenes of a folder, to train on.

    Raises:
        SceneFilesError: it holds no scenes, or those of the test split.
    """
    settings = read_settings(folder)
    if settings.split != "train":
        raise SceneFilesError(f"{folder}: scenes of the {settings.split} split; train on others")
    return SyntheticScenes(folder, scene_names(folder), settings.views)


def read_sample(folder: Path, name: str) -> Sample:
    """A scene as a training sample: all four maps are labelled, but for ground far behind walls.

    Raises:
        SceneFilesError: it is missing or damaged.
    """
    scene = read_scene(folder, name)
    return scene_sample(f"{folder.name}/{name}", scene.image, scene.intrinsics, scene.ground_truth)


def scene_sample(
    name: str, image: NDArray[np.uint8], intrinsics: Intrinsics, exact: SceneGroundTruth
) -> Sample:
    """The photo of a scene and its exact ground truth as a training sample."""
    ground = np.where(exact.bits & pixels.GROUND_ANYWHERE > 0, YES, NO).astype(np.uint8)
    ground[exact.bits & pixels.FOOTPRINT > 0] = FOOTPRINT
    gap_m = exact.ground_depth_m - exact.visible_depth_m
    ground[(exact.bits & pixels.BEHIND_WALL > 0) & (gap_m > MOST_BEHIND_WALL_M)] = UNSEEN
    return Sample(
        name,
        image,
        intrinsics,
        np.where(exact.bits & pixels.VISIBLE_GROUND > 0, YES, NO).astype(np.uint8),
        ground,
        exact.visible_depth_m.astype(np.float16),
        np.where(ground == YES, exact.ground_depth_m, 0).astype(np.float16),
    )
