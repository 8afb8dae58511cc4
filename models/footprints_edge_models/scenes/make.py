"""Fills a folder with made scenes, on all cores; what is there already is kept."""

import io
import json
import multiprocessing
import os
import signal
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.generate import SyntheticScene, generate_scene
from footprints_edge_models.scenes.ground_truth.boxes import boxes_of
from footprints_edge_models.scenes.ground_truth.voxels import CLASSES, voxels_of
from footprints_edge_models.scenes.storage.files import (
    SceneSettings,
    scene_name,
    write_scene,
    write_settings,
)

Report = Callable[[int], None]
"""Told the bytes of every scene that is done; 0 for one that was there before."""


@dataclass(frozen=True)
class _Job:
    folder: Path
    settings: SceneSettings
    library: TextureLibrary


_job: _Job | None = None


def make_scenes(
    folder: Path,
    settings: SceneSettings,
    textures: list[Path],
    count: int,
    jobs: int,
    report: Report,
    first: int = 0,
) -> None:
    """Makes the scenes ``first`` to ``first + count`` that are not there yet.

    Args:
        folder: where to; a folder begun before is gone on with.
        settings: what kind of scenes; its ``textures`` are filled in from ``textures``.
        textures: folders of photos, whose crops become textures.
        count: how many.
        jobs: processes.
        report: told about every scene.
        first: number of the first; parts of one set can be made on several machines.

    Raises:
        SceneFilesError: the folder was begun with other settings.
    """
    library = TextureLibrary.over(settings.split, textures)
    named = tuple(
        (path.resolve().name, sum(path in photo.parents for photo in library.photos))
        for path in textures
    )
    settings = SceneSettings(settings.split, settings.seed, settings.size, named)
    write_settings(folder, settings)
    missing = []
    for number in range(first, first + count):
        if (folder / "truth" / f"{scene_name(number)}.npz").is_file():
            report(0)
        else:
            missing.append(number)
    job = _Job(folder, settings, library)
    if jobs == 1 or len(missing) < 2:
        _begin(job)
        for number in missing:
            report(_make(number))
    else:
        _in_processes(job, missing, jobs, report)
    if settings.split == "test":
        _gather_boxes(folder)


def _in_processes(job: _Job, numbers: list[int], jobs: int, report: Report) -> None:
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    with ProcessPoolExecutor(
        jobs,
        mp_context=multiprocessing.get_context("spawn"),
        initializer=_begin_process,
        initargs=(job,),
    ) as pool:
        todo = iter(numbers)
        running: set[Future[int]] = set()
        try:
            while True:
                while len(running) < 2 * jobs and (number := next(todo, None)) is not None:
                    running.add(pool.submit(_make, number))
                if not running:
                    return
                done, running = wait(running, return_when=FIRST_COMPLETED)
                for future in done:
                    report(future.result())
        finally:
            for future in running:
                future.cancel()


def _begin_process(job: _Job) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to handle
    cv2.setNumThreads(1)
    _begin(job)


def _begin(job: _Job) -> None:
    global _job  # noqa: PLW0603  (it is how a process of a pool keeps something)
    _job = job


def _make(number: int) -> int:
    assert _job is not None, "the process was begun"
    job = _job
    made = generate_scene(job.library, job.settings.seed, number, job.settings.size)
    name = scene_name(number)
    if job.settings.split == "test":
        _write_solids(job.folder, name, made)
    quality = int(np.random.default_rng((number, job.settings.seed)).integers(55, 93))
    return write_scene(
        job.folder, name, made.scene, made.camera, made.image, made.ground_truth, quality
    )


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
