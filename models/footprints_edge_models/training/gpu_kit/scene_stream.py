"""Views of synthetic scenes from all cores, without an end.

The main process trains meanwhile: a thread of it collects what the others make. A process that dies
is replaced (``parallel.processes``). Nothing here needs torch.
"""

import itertools
import logging
import queue
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2

from footprints_edge.foundation.types import Size
from footprints_edge.parallel.job import ItemOutcome
from footprints_edge.parallel.processes import run_in_processes
from footprints_edge_models.data.readers.synthetic_scenes import scene_sample
from footprints_edge_models.sample import Sample
from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.generate import generate_views
from footprints_edge_models.scenes.make import scene_library
from footprints_edge_models.training.gpu_kit.stored_view import StoredView, stored_view

logger = logging.getLogger(__name__)

MOST_SCENES = 100_000
VIEWS = 8
"""Views of each scene: making it is most of the cost; 4 are a fifth fewer a second."""
_MOST_WAITING = 256
_MOST_TOLD = 5
_HOPELESS = 100
"""If so many scenes fail before any is made, none ever will."""


def views_of_scene(library: TextureLibrary, seed: int, number: int, size: Size) -> Iterator[Sample]:
    """All views of one scene, as samples."""
    for made in generate_views(library, seed, number, size, VIEWS):
        name = f"{number}/{made.view}"
        yield scene_sample(name, made.image, made.camera.intrinsics, made.ground_truth)


@dataclass(frozen=True)
class SceneViews:
    """A job of ``parallel``: the views of a scene, by the scene's number; each as bytes.

    Attributes:
        library: Textures and models.
        seed: Of all scenes.
        size: (H, W) of a landscape picture.
        most_px: No view has more pixels.
    """

    library: TextureLibrary
    seed: int
    size: Size
    most_px: int

    @classmethod
    def of(cls, assets: Path | None, seed: int, size: Size, most_px: int) -> "SceneViews":
        """Scenes of the training split, with a pack of assets or without."""
        return cls(scene_library("train", [], assets), seed, size, most_px)

    def finished(self, number: int) -> list[bytes] | None:  # noqa: ARG002  (a job has it)
        """Nothing is kept."""
        return None

    def start(self) -> Callable[[int], list[bytes]]:
        """The function that makes a scene's views."""
        cv2.setNumThreads(1)  # there is a process for every core
        return self._make

    def _make(self, number: int) -> list[bytes]:
        views = views_of_scene(self.library, self.seed, number, self.size)
        return [stored_view(view, self.most_px).to_bytes() for view in views]


class SceneStream:
    """Views as they come, while the main process does something else."""

    def __init__(self, job: SceneViews, processes: int) -> None:
        """Starts the processes; they make scenes until :meth:`close`."""
        self.scenes = self.failed = 0
        self._job = job
        self._processes = processes
        self._views: queue.Queue[StoredView] = queue.Queue(_MOST_WAITING)
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._collect, name="scenes", daemon=True)
        self._thread.start()

    def ready(self, most: int) -> Iterator[StoredView]:
        """Views that are there, at most so many."""
        for _ in range(most):
            try:
                yield self._views.get_nowait()
            except queue.Empty:
                return

    @property
    def waiting(self) -> int:
        """Views that nobody has taken yet."""
        return self._views.qsize()

    @property
    def alive(self) -> bool:
        """Whether more may come."""
        return self._thread.is_alive()

    def close(self) -> None:
        """Ends the processes when each has finished its scene."""
        self._closed.set()
        self._thread.join(timeout=30)

    def _collect(self) -> None:
        first = 0
        for attempt in itertools.count():
            try:
                numbers = range(first, first + MOST_SCENES)
                processes = self._processes
                run_in_processes(self._job, numbers, self._take, processes=processes, run_length=1)
                return
            except _ClosedError:
                return
            except Exception:  # training goes on with what is there, and this tries again
                logger.exception("scenes stopped; they start again")
                first += MOST_SCENES
                if attempt == 5 or self._closed.wait(2):
                    return

    def _take(self, outcome: ItemOutcome[int, list[bytes]]) -> None:
        if outcome.result is None:
            self.failed += 1
            if self.failed <= _MOST_TOLD:
                logger.warning("scene %d failed: %s", outcome.item, outcome.reason)
            if self.failed >= _HOPELESS and not self.scenes:
                logger.error("%d scenes failed and none was made: no more are tried", self.failed)
                raise _ClosedError
        else:
            self.scenes += 1
            for data in outcome.result:
                self._put(StoredView.from_bytes(data))
        if self._closed.is_set():
            raise _ClosedError

    def _put(self, view: StoredView) -> None:
        """Waits where training is slower than the scenes."""
        while not self._closed.is_set():
            try:
                self._views.put(view, timeout=0.5)
                return
            except queue.Full:
                time.sleep(0)


class _ClosedError(Exception):
    """Nobody wants more scenes."""
