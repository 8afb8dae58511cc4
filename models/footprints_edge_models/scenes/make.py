"""Fills a folder with synthetic scenes, on all cores; finished scenes are kept."""

import io
import json
import multiprocessing
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge.parallel.job import ReportOutcome
from footprints_edge.parallel.processes import run_in_processes
from footprints_edge.parallel.serial import run_serially
from footprints_edge_models.asset_files.pack import AssetPack
from footprints_edge_models.scenes.assets.models import ModelLibrary
from footprints_edge_models.scenes.assets.textures.library import SceneSplit, TextureLibrary
from footprints_edge_models.scenes.credits import write_credits
from footprints_edge_models.scenes.generate import SyntheticScene, generate_scene
from footprints_edge_models.scenes.ground_truth.boxes import boxes_of
from footprints_edge_models.scenes.ground_truth.voxels import CLASSES, voxels_of
from footprints_edge_models.scenes.storage.files import (
    SceneSettings,
    scene_bytes,
    scene_name,
    write_scene,
    write_settings,
)


@dataclass(frozen=True)
class SceneJob:
    """The scenes of a folder, by number; the result of a scene is the bytes that it takes.

    Attributes:
        folder: where the scenes go.
        settings: decide every scene.
        library: textures of the settings' split.
    """

    folder: Path
    settings: SceneSettings
    library: TextureLibrary

    def finished(self, number: int) -> int | None:
        """The bytes of a scene that is there."""
        return scene_bytes(self.folder, scene_name(number))

    def start(self) -> Callable[[int], int]:
        """The function that makes a scene."""
        if multiprocessing.parent_process() is not None:
            cv2.setNumThreads(1)  # there is a process for every core
        return self._make

    def _make(self, number: int) -> int:
        settings, name = self.settings, scene_name(number)
        made = generate_scene(self.library, settings.seed, number, settings.size)
        if settings.split == "test":
            _write_solids(self.folder, name, made)
        quality = int(np.random.default_rng((number, settings.seed)).integers(55, 93))
        return write_scene(
            self.folder, name, made.scene, made.camera, made.image, made.ground_truth, quality
        )


def make_scenes(
    folder: Path,
    settings: SceneSettings,
    textures: list[Path],
    count: int,
    processes: int,
    report: ReportOutcome[int, int],
    first: int = 0,
    assets: Path | None = None,
) -> None:
    """Makes the scenes ``first`` to ``first + count`` that are not there yet.

    A scene that fails is reported, and the others are made.

    Args:
        folder: where to; an unfinished folder is resumed.
        settings: of the scenes; their ``textures`` are filled in from ``textures``.
        textures: folders of photos, whose crops become textures.
        count: number of scenes.
        processes: number of processes; with one, the scenes are made in this process.
        report: called with the outcome of every scene.
        first: number of the first scene; parts of one set can be made on several machines.
        assets: pack of 3D models to furnish with; see ``asset_files.pack``.

    Raises:
        SceneFilesError: the folder was begun with other settings.
        AssetError: the pack cannot be read.
    """
    library = scene_library(settings.split, textures, assets)
    named = tuple(
        (path.resolve().name, sum(path in photo.parents for photo in library.photos))
        for path in textures
    )
    pack = None if assets is None else AssetPack(assets)
    settings = replace(settings, textures=named, assets=pack.fingerprint if pack else "")
    write_settings(folder, settings)
    job, numbers = SceneJob(folder, settings, library), range(first, first + count)
    try:
        if processes == 1:
            run_serially(job, numbers, report)
        else:
            run_in_processes(job, numbers, report, processes=processes, run_length=1)
    finally:  # an interrupted folder is credited, too
        if pack is not None:
            write_credits(folder, pack)
    if settings.split == "test":
        _gather_boxes(folder)


def scene_library(split: SceneSplit, textures: list[Path], assets: Path | None) -> TextureLibrary:
    """What the scenes of a split are made of.

    Args:
        split: train or test.
        textures: folders of photos.
        assets: pack of 3D models; see ``asset_files.pack``.
    """
    library = TextureLibrary.over(split, textures)
    if assets is not None:
        library = replace(library, models=ModelLibrary(assets, split))
    return library


def _write_solids(folder: Path, name: str, made: SyntheticScene) -> None:
    """Boxes and voxels of a scene, for the baselines that need them."""
    boxes = json.dumps(boxes_of(made.scene, made.camera))
    write_atomically(folder / "boxes" / f"{name}.json", boxes.encode())
    voxels = voxels_of(made.scene, made.geometry, made.camera)
    arrays = io.BytesIO()
    np.savez_compressed(
        arrays,
        labels=voxels.labels,
        origin_m=voxels.origin_m,
        voxel_m=np.array(voxels.voxel_m),
        camera_to_grid=voxels.camera_to_grid,
        class_names=np.array(CLASSES),
    )
    write_atomically(folder / "voxels" / f"{name}.npz", arrays.getvalue())


def _gather_boxes(folder: Path) -> None:
    """One file of boxes for all scenes: FOLDER/NAME to a list of boxes."""
    title = folder.resolve().name
    boxes = {
        f"{title}/{path.stem}": json.loads(path.read_text(encoding="utf-8"))
        for path in sorted((folder / "boxes").glob("[0-9]*.json"))
    }
    write_atomically(folder / "boxes.json", json.dumps(boxes).encode())
