"""A job in this process, one item after the other."""

from collections.abc import Iterable

from footprints_edge.parallel.job import ItemT, Job, ReportOutcome, ResultT, Worker, unfinished


def run_serially(
    job: Job[ItemT, ResultT], items: Iterable[ItemT], report: ReportOutcome[ItemT, ResultT]
) -> None:
    """Works on every item that is not finished.

    Args:
        job: the work.
        items: all items.
        report: called for every item, those that were finished before included.
    """
    worker = Worker(job)
    for item in unfinished(job, items, report):
        report(worker.do(item))
