"""A label job on Ray: the cores of this machine, or of a cluster that sees the same files.

Tasks are short runs of frames. A task whose worker or machine dies is started again by Ray and
skips the frames that have their files, so nothing is lost and no finished frame is made twice.
"""

import logging
import os
from uuid import uuid4

import ray

from footprints_edge_models.video_labels.files import remove_fragments
from footprints_edge_models.video_labels.job import (
    FrameOutcome,
    LabelJob,
    LabelWorker,
    Report,
    finished,
    in_runs,
    in_this_run,
    prepare,
)

FRAMES_A_TASK = 8
"""Long enough for a worker to use what it has read of the neighbours, short enough to spread."""
RETRIES = 3
"""How often Ray starts a task again whose worker died."""

_workers: dict[str, LabelWorker] = {}


def run_on_ray(job: LabelJob, workers: int, report: Report) -> None:
    """Labels every frame that has no labels yet.

    The cluster is the one that RAY_ADDRESS names, or that Ray is connected to already; else one of
    so many worker processes is started here and ended afterwards.

    Args:
        job: what to label; its files must be where every machine of the cluster sees them.
        workers: how many processes, where the cluster is started here.
        report: told about every frame, those that were done before included.

    Raises:
        FootprintsError: the job cannot be done at all; see :func:`job.prepare`.
    """
    to_do = prepare(job, report)
    if not to_do:
        return
    ours = not ray.is_initialized()
    if ours:
        _connect(workers)
    try:
        _run(job, to_do, report)
    finally:
        if ours:
            ray.shutdown()
        remove_fragments(job.folder)


def _connect(workers: int) -> None:
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    if "RAY_ADDRESS" in os.environ:
        ray.init(log_to_driver=False)
        return
    ray.init(
        num_cpus=workers,
        include_dashboard=False,
        log_to_driver=False,
        logging_level=logging.WARNING,
        object_store_memory=256 * 2**20,  # only the description of the sequence is shared
    )


def _run(job: LabelJob, to_do: list[int], report: Report) -> None:
    label_frames = ray.remote(max_retries=RETRIES)(_label_frames)
    shared, key = ray.put(job), uuid4().hex
    parts = -(-len(to_do) // FRAMES_A_TASK)
    running = {label_frames.remote(shared, key, run): run for run in in_runs(to_do, parts)}
    while running:
        (ready,), _ = ray.wait(list(running))
        run = running.pop(ready)
        try:
            outcomes = ray.get(ready)
        except ray.exceptions.RayError as error:
            # Its worker died again and again. One frame does that; the others need not suffer.
            if len(run) > 1:
                running |= {label_frames.remote(shared, key, [i]): [i] for i in run}
                continue
            last_line = str(error).strip().rsplit("\n", 1)[-1]
            reason = f"Ray gave up on it: {type(error).__name__}: {last_line}"
            name = job.sequence.frames[run[0]].name
            outcomes = [finished(job, run[0]) or FrameOutcome(name, "failed", reason)]
        for outcome in outcomes:
            report(in_this_run(outcome))


def _label_frames(job: LabelJob, key: str, indices: list[int]) -> list[FrameOutcome]:
    """A task. A process keeps its worker for the next task of the same job."""
    if key not in _workers:
        _workers.clear()
        _workers[key] = LabelWorker(job)
    return [_workers[key].label(index) for index in indices]
