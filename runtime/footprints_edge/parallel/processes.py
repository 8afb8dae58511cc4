"""A job on the cores of one machine.

Every process works on runs of contiguous items, one item after the other, so that what it keeps in
memory of one item serves the next. A process that dies costs nothing but the item it was at:
another takes its place and tries that item once more.
"""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any, Generic

from footprints_edge.parallel.job import (
    ItemOutcome,
    ItemT,
    Job,
    ReportOutcome,
    ResultT,
    Worker,
    in_runs,
    unfinished,
)

DIED_TWICE = "the worker process died at it twice, killed from outside or for want of memory"

_worker: Worker[Any, Any] | None = None


def run_in_processes(
    job: Job[ItemT, ResultT],
    items: Iterable[ItemT],
    report: ReportOutcome[ItemT, ResultT],
    *,
    processes: int,
    run_length: int | None = None,
) -> None:
    """Works on every item that is not finished.

    Args:
        job: the work; pickled to every process.
        items: all items.
        report: called for every item, those that were finished before included.
        processes: number of processes.
        run_length: items that a process takes at a time; None gives every process one contiguous
            part of all.
    """
    to_do = unfinished(job, items, report)
    parts = processes if run_length is None else -(-len(to_do) // run_length)
    runs = deque(in_runs(to_do, parts))
    lanes = [_Lane(job, runs) for _ in range(min(processes, len(runs)))]
    try:
        with _one_thread_each():
            for lane in lanes:
                lane.start()
            while busy := [lane for lane in lanes if lane.future is not None]:
                wait([lane.future for lane in busy if lane.future], return_when=FIRST_COMPLETED)
                for lane in busy:
                    for outcome in lane.collect():
                        report(outcome)
    finally:
        for lane in lanes:  # after an interruption, each finishes the item it is at
            lane.stop()


class _Lane(Generic[ItemT, ResultT]):
    """One worker process and the run of items that it works on."""

    def __init__(self, job: Job[ItemT, ResultT], runs: deque[list[ItemT]]) -> None:
        """Takes its first run.

        Args:
            job: the work.
            runs: runs that no lane has taken yet; shared by all lanes.
        """
        self._job = job
        self._runs = runs
        self._waiting = deque(runs.popleft())
        self._died_at: ItemT | None = None
        self._pool: ProcessPoolExecutor | None = None
        self.future: Future[ItemOutcome[ItemT, ResultT]] | None = None

    def start(self) -> None:
        """Starts the process, with the first item waiting."""
        self._pool = ProcessPoolExecutor(
            1,
            # fork would copy locked locks of the parent's threads; spawn works everywhere
            mp_context=multiprocessing.get_context("spawn"),
            initializer=_begin,
            initargs=(self._job,),
        )
        self._submit()

    def collect(self) -> list[ItemOutcome[ItemT, ResultT]]:
        """The outcomes since the last call, at most one; goes on with the next item."""
        if self.future is None or not self.future.done():
            return []
        item = self._waiting[0]
        try:
            outcome = self.future.result()
        except BrokenProcessPool:
            self.stop()
            if self._died_at != item:
                self._died_at = item
                self.start()
                return []
            outcome = ItemOutcome(item, "failed", reason=DIED_TWICE)
            self._advance()
            if self._waiting:
                self.start()
            return [outcome]
        self._advance()
        self._submit()
        return [outcome]

    def stop(self) -> None:
        """Ends the process when it has finished its item."""
        self.future = None
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            self._pool = None

    def _advance(self) -> None:
        self._waiting.popleft()
        if not self._waiting and self._runs:
            self._waiting.extend(self._runs.popleft())

    def _submit(self) -> None:
        self.future = None
        if self._pool is not None and self._waiting:
            try:
                self.future = self._pool.submit(_do, self._waiting[0])
            except BrokenProcessPool:  # it died between two items: neither of them is to blame
                self.stop()
                self.start()


def _begin(job: Job[Any, Any]) -> None:
    global _worker  # noqa: PLW0603  (it is how a process of a pool keeps something)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to handle
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _worker = Worker(job)


def _end_with_parent() -> None:
    """Ends this process when its parent is gone, killed: the pool alone would wait forever."""
    parent = multiprocessing.parent_process()
    assert parent is not None, "only the processes of a pool run this"
    parent.join()
    os._exit(1)


def _do(item: Any) -> ItemOutcome[Any, Any]:  # noqa: ANN401
    assert _worker is not None, "the pool's initializer has run"
    return _worker.do(item)


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
