"""Fills a folder with pictures of synthetic scenes, on all cores; finished ones are kept."""

import io
import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge.parallel.job import ReportOutcome
from footprints_edge.parallel.on_ray import run_on_ray
from footprints_edge.parallel.processes import run_in_processes
from footprints_edge.parallel.serial import run_serially
from footprints_edge_models.asset_files.pack import AssetPack
from footprints_edge_models.scenes.assets.models import ModelLibrary
from footprints_edge_models.scenes.assets.textures.library import SceneSplit, TextureLibrary
from footprints_edge_models.scenes.assets.textures.photographed import PackPictures
from footprints_edge_models.scenes.assets.worlds import WorldLibrary
from footprints_edge_models.scenes.credits import write_credits
from footprints_edge_models.scenes.generate import SyntheticScene, generate_views
from footprints_edge_models.scenes.ground_truth.boxes import boxes_of
from footprints_edge_models.scenes.ground_truth.voxels import CLASSES, voxels_of
from footprints_edge_models.scenes.storage.files import (
    SceneSettings,
    scene_bytes,
    scene_name,
    scene_views,
    write_scene,
    write_settings,
)


@dataclass(frozen=True)
class ScenePictures:
    """What became of the pictures of a scene.

    Attributes:
        made: the bytes that each new one takes.
        kept: number of those that were there.
    """

    made: tuple[int, ...]
    kept: int


@dataclass(frozen=True)
class SceneJob:
    """The scenes of a folder, by number.

    Attributes:
        folder: where the pictures go.
        settings: decide every scene.
        library: textures of the settings' split.
        pictures: numbers of the pictures that shall be in the folder.
        shares_cores: whether other processes work on it as well, one for every core.
    """

    folder: Path
    settings: SceneSettings
    library: TextureLibrary
    pictures: range
    shares_cores: bool

    @property
    def scenes(self) -> range:
        """The scenes that the pictures show."""
        views = self.settings.views
        return range(self.pictures.start // views, -(-self.pictures.stop // views))

    def pictures_of(self, scene: int) -> range:
        """The pictures of a scene that shall be in the folder."""
        first = scene * self.settings.views
        return range(
            max(first, self.pictures.start), min(first + self.settings.views, self.pictures.stop)
        )

    def finished(self, scene: int) -> ScenePictures | None:
        """The pictures of a scene, if all that it has are there."""
        missing = self._missing(scene)
        kept = len(self.pictures_of(scene)) - len(missing)
        if missing and missing[0] - scene * self.settings.views < self._views(scene):
            return None
        return ScenePictures((), kept)

    def start(self) -> Callable[[int], ScenePictures]:
        """The function that makes the missing pictures of a scene."""
        if self.shares_cores:
            cv2.setNumThreads(1)
        return self._make

    def _missing(self, scene: int) -> list[int]:
        return [
            picture
            for picture in self.pictures_of(scene)
            if scene_bytes(self.folder, scene_name(picture)) is None
        ]

    def _views(self, scene: int) -> int:
        """How many views a scene has, as its pictures say; without any, as are asked for."""
        views, first = self.settings.views, scene * self.settings.views
        if views == 1:
            return 1
        said = (scene_views(self.folder, scene_name(first + view)) for view in range(views))
        return next((count for count in said if count is not None), views)

    def _make(self, scene: int) -> ScenePictures:
        settings, missing = self.settings, self._missing(scene)
        first, sizes = scene * settings.views, []
        wanted = {picture - first for picture in missing}
        for made in generate_views(
            self.library, settings.seed, scene, settings.size, settings.views, wanted
        ):
            picture = first + made.view
            name = scene_name(picture)
            if settings.split == "test":
                _write_solids(self.folder, name, made)
            quality = int(np.random.default_rng((picture, settings.seed)).integers(55, 93))
            sizes.append(
                write_scene(
                    self.folder,
                    name,
                    made.scene,
                    made.camera,
                    made.image,
                    made.ground_truth,
                    quality,
                    made.views,
                )
            )
        return ScenePictures(tuple(sizes), len(self.pictures_of(scene)) - len(missing))


def make_scenes(
    folder: Path,
    settings: SceneSettings,
    textures: list[Path],
    count: int,
    processes: int,
    report: ReportOutcome[int, ScenePictures],
    first: int = 0,
    assets: Path | None = None,
    *,
    on_ray: bool = False,
) -> None:
    """Makes the pictures ``first`` to ``first + count`` that are not there yet.

    A scene that fails is reported, and the others are made. A scene may have fewer views than the
    settings ask for; the numbers of the others stay free.

    Args:
        folder: where to; an unfinished folder is resumed.
        settings: of the scenes; their ``textures`` are filled in from ``textures``.
        textures: folders of photos, whose crops become textures.
        count: number of pictures.
        processes: number of processes; with one, the scenes are made in this process.
        report: called with the outcome of every scene.
        first: number of the first picture; parts of one set can be made on several machines.
        assets: pack of 3D models to furnish with; see ``asset_files.pack``.
        on_ray: whether Ray's workers make the scenes, ``processes`` of them where no cluster runs.
            All files must be where every machine of the cluster sees them.

    Raises:
        SceneFilesError: the folder was begun with other settings.
        AssetError: the pack cannot be read.
    """
    # Ray's workers have working directories of their own.
    folder, textures = folder.absolute(), [path.absolute() for path in textures]
    assets = None if assets is None else assets.absolute()
    library = scene_library(settings.split, textures, assets)
    named = tuple(
        (path.resolve().name, sum(path in photo.parents for photo in library.photos))
        for path in textures
    )
    pack = None if assets is None else AssetPack(assets)
    settings = replace(settings, textures=named, assets=pack.fingerprint if pack else "")
    write_settings(folder, settings)
    shares_cores = on_ray or processes > 1
    job = SceneJob(folder, settings, library, range(first, first + count), shares_cores)
    try:
        if on_ray:
            run_on_ray(job, job.scenes, report, workers=processes, run_length=1)
        elif processes == 1:
            run_serially(job, job.scenes, report)
        else:
            run_in_processes(job, job.scenes, report, processes=processes, run_length=1)
    finally:  # an interrupted folder is credited, too
        if pack is not None or textures:
            write_credits(folder, pack, textures)
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
        library = replace(
            library,
            models=ModelLibrary(assets, split),
            worlds=WorldLibrary(assets, split),
            pictures=PackPictures(assets, split),
        )
    return library


def _write_solids(folder: Path, name: str, made: SyntheticScene) -> None:
    """Boxes and voxels of a view, for the baselines that need them."""
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
    """One file of boxes for all pictures: FOLDER/NAME to a list of boxes."""
    title = folder.resolve().name
    boxes = {
        f"{title}/{path.stem}": json.loads(path.read_text(encoding="utf-8"))
        for path in sorted((folder / "boxes").glob("[0-9]*.json"))
    }
    write_atomically(folder / "boxes.json", json.dumps(boxes).encode())
