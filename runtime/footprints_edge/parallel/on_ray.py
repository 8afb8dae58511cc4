"""A job on Ray: the cores of this machine, or of a cluster that sees the same files.

Tasks are short runs of items. A task whose worker or machine dies is started again by Ray and skips
the items that are finished, so nothing is lost and no finished item is done twice.
"""

import logging
import os
from collections.abc import Iterable
from typing import Any
from uuid import uuid4

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

RETRIES = 3
"""How often Ray starts a task again whose worker died."""

_workers: dict[str, Worker[Any, Any]] = {}


def run_on_ray(
    job: Job[ItemT, ResultT],
    items: Iterable[ItemT],
    report: ReportOutcome[ItemT, ResultT],
    *,
    workers: int,
    run_length: int,
) -> None:
    """Works on every item that is not finished.

    The cluster is the one that RAY_ADDRESS names, or that Ray is connected to already; else one is
    started here and ended afterwards.

    Args:
        job: the work; its files must be where every machine of the cluster sees them.
        items: all items.
        report: called for every item, those that were finished before included.
        workers: number of worker processes, where the cluster is started here.
        run_length: items per task, done by one worker in order.
    """
    import ray

    to_do = unfinished(job, items, report)
    if not to_do:
        return
    ours = not ray.is_initialized()
    if ours:
        _connect(workers)
    try:
        _run(job, to_do, report, run_length)
    finally:
        if ours:
            ray.shutdown()


def require_ray() -> None:
    """Raises `ModuleNotFoundError` where Ray is missing, before any work."""
    import ray  # noqa: F401


def _connect(workers: int) -> None:
    import ray

    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    if "RAY_ADDRESS" in os.environ:
        ray.init(log_to_driver=False)
        return
    ray.init(
        num_cpus=workers,
        include_dashboard=False,
        log_to_driver=False,
        logging_level=logging.WARNING,
        object_store_memory=256 * 2**20,  # only the description of the job is shared
    )


def _run(
    job: Job[ItemT, ResultT],
    to_do: list[ItemT],
    report: ReportOutcome[ItemT, ResultT],
    run_length: int,
) -> None:
    import ray

    task: Any = ray.remote(max_retries=RETRIES)(_do_run)
    shared, key = ray.put(job), uuid4().hex
    runs = in_runs(to_do, -(-len(to_do) // run_length))
    running = {task.remote(shared, key, run): run for run in runs}
    while running:
        (ready,), _ = ray.wait(list(running))
        run = running.pop(ready)
        try:
            outcomes = ray.get(ready)
        except ray.exceptions.RayError as error:
            # Its worker died again and again. One item does that; the others need not suffer.
            if len(run) > 1:
                running |= {task.remote(shared, key, [item]): [item] for item in run}
                continue
            outcomes = [_given_up(job, run[0], error)]
        for outcome in outcomes:
            report(outcome)


def _given_up(
    job: Job[ItemT, ResultT], item: ItemT, error: Exception
) -> ItemOutcome[ItemT, ResultT]:
    """The outcome of an item whose task failed; it may have been finished all the same."""
    if (result := job.finished(item)) is not None:
        return ItemOutcome(item, "done", result)
    last_line = str(error).strip().rsplit("\n", 1)[-1]
    reason = f"Ray gave up on it: {type(error).__name__}: {last_line}"
    return ItemOutcome(item, "failed", reason=reason)


def _do_run(
    job: Job[ItemT, ResultT], key: str, items: list[ItemT]
) -> list[ItemOutcome[ItemT, ResultT]]:
    """A task. A process keeps its worker for the next task of the same job."""
    if key not in _workers:
        _workers.clear()
        _workers[key] = Worker(job)
    return [_workers[key].do(item) for item in items]
