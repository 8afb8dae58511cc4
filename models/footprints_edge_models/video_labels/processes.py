"""A label job on the cores of one machine.

Every worker process labels a contiguous part of the sequence, one frame after the other, so that
what it has read of the neighbours serves the next frame too. A worker that dies costs nothing but
the frame it was at: another takes its place and tries that frame once more.
"""

import multiprocessing
import os
import signal
from collections import deque
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

from footprints_edge_models.video_labels.files import remove_fragments
from footprints_edge_models.video_labels.job import (
    FrameOutcome,
    LabelJob,
    LabelWorker,
    Report,
    in_runs,
    in_this_run,
    prepare,
)

DIED_TWICE = "the worker process died at it twice, killed from outside or for want of memory"

_worker: LabelWorker | None = None


def run_in_processes(job: LabelJob, processes: int, report: Report) -> None:
    """Labels every frame that has no labels yet.

    Args:
        job: what to label.
        processes: how many at a time.
        report: told about every frame, those that were done before included.

    Raises:
        FootprintsError: the job cannot be done at all; see :func:`job.prepare`.
    """
    to_do = prepare(job, report)
    lanes = [_Lane(job, part) for part in in_runs(to_do, processes)]
    try:
        with _one_thread_each():
            for lane in lanes:
                lane.start()
            while busy := [lane for lane in lanes if lane.future is not None]:
                wait([lane.future for lane in busy if lane.future], return_when=FIRST_COMPLETED)
                for lane in busy:
                    for outcome in lane.collect():
                        report(in_this_run(outcome))
    finally:
        for lane in lanes:  # after an interruption, each finishes the frame it is at
            lane.stop()
        remove_fragments(job.folder)


class _Lane:
    """One worker process and the frames it has still to label."""

    def __init__(self, job: LabelJob, indices: list[int]) -> None:
        self._job = job
        self._waiting = deque(indices)
        self._died_at: int | None = None
        self._pool: ProcessPoolExecutor | None = None
        self.future: Future[FrameOutcome] | None = None

    def start(self) -> None:
        """Starts the process, with the first frame waiting."""
        self._pool = ProcessPoolExecutor(
            1,
            # fork would copy locked locks of the parent's threads; spawn works everywhere
            mp_context=multiprocessing.get_context("spawn"),
            initializer=_begin,
            initargs=(self._job,),
        )
        self._next()

    def collect(self) -> list[FrameOutcome]:
        """What is known since the last time, at most one outcome; goes on with the next frame."""
        if self.future is None or not self.future.done():
            return []
        index = self._waiting[0]
        try:
            outcome = self.future.result()
        except BrokenProcessPool:
            self.stop()
            if self._died_at != index:
                self._died_at = index
                self.start()
                return []
            self._waiting.popleft()
            if self._waiting:
                self.start()
            name = self._job.sequence.frames[index].name
            return [FrameOutcome(name, "failed", DIED_TWICE)]
        self._waiting.popleft()
        self._next()
        return [outcome]

    def stop(self) -> None:
        """Ends the process when it has finished its frame."""
        self.future = None
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None

    def _next(self) -> None:
        self.future = None
        if self._pool is not None and self._waiting:
            self.future = self._pool.submit(_label, self._waiting[0])


def _begin(job: LabelJob) -> None:
    global _worker  # noqa: PLW0603  (it is how a process of a pool keeps something)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to handle
    _worker = LabelWorker(job)


def _label(index: int) -> FrameOutcome:
    assert _worker is not None, "the pool's initializer has run"
    return _worker.label(index)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Numerical libraries of processes started meanwhile use one thread, unless told otherwise."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    added = [name for name in names if name not in os.environ]
    os.environ.update(dict.fromkeys(added, "1"))
    try:
        yield
    finally:
        for name in added:
            os.environ.pop(name, None)
