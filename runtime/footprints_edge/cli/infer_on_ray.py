"""The part of `fp-infer` for pictures on a Ray cluster, whose machines see the same files."""

import sys
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from footprints_edge.cli.batch import Batch, Task
from footprints_edge.cli.infer_images import Outcome, Reporter, work
from footprints_edge.parallel.job import ItemOutcome
from footprints_edge.parallel.on_ray import run_on_ray

PICTURES_PER_TASK = 8

_Stamp: TypeAlias = tuple[int, int, int]


def infer_on_ray(
    batch: Batch,
    model: str | None,
    how: Mapping[str, Any],
    *,
    workers: int,
    quiet: bool,
    verbose: bool,
) -> None:
    """Runs the tasks of a batch and prints the files written, in the order of the pictures.

    Args:
        batch: The tasks; all of files.
        model: Model file or registered name; None means the bundled model.
        how: Arguments of `Model.predict`.
        workers: Worker processes, each with one thread, where the cluster is started here.
        quiet: Whether to print results and errors only.
        verbose: Whether to print a line for each picture.

    Raises:
        ModelError: If the model cannot be loaded.
    """
    from footprints_edge.model import load

    model = str(load(model, threads=1).path.absolute())  # a wrong model is told once
    items = [_absolute(number, task) for number, task in enumerate(batch.tasks)]
    job = _PictureJob(model, how, verbose, {path: _stamp(path) for i in items for path in i.paths})
    report = Reporter(batch, quiet=quiet)
    waiting: dict[int, Outcome] = {}
    told, stdout = 0, sys.stdout

    def collect(found: ItemOutcome[_Item, Outcome]) -> None:
        nonlocal told
        outcome, task = found.result, batch.tasks[found.item.number]
        if outcome is None:
            outcome = Outcome(failure=f"{task.source.label}: {found.reason}")
        given = dict(zip(found.item.paths, task.targets, strict=True))
        waiting[found.item.number] = replace(outcome, written=[given[p] for p in outcome.written])
        while told in waiting:
            with redirect_stdout(stdout):
                report(waiting.pop(told))
            told += 1
            if told < len(items):
                report.show(told, batch.tasks[told])

    try:
        with redirect_stdout(sys.stderr):  # where Ray's own words belong
            run_on_ray(job, items, collect, workers=workers, run_length=PICTURES_PER_TASK)
    finally:
        report.clear()


@dataclass(frozen=True)
class _Item:
    """A task with absolute paths, and its place in the batch."""

    number: int
    task: Task

    @property
    def paths(self) -> tuple[Path, ...]:
        return tuple(self.task.targets)


def _absolute(number: int, task: Task) -> _Item:
    assert task.source.path is not None, "standard input is refused"
    source = replace(task.source, path=task.source.path.absolute())
    targets = {path.absolute(): encode for path, encode in task.targets.items()}
    return _Item(number, Task(source, targets))


@dataclass(frozen=True)
class _PictureJob:
    """A `Job`.

    Attributes:
        model: Path of the model file.
        how: Arguments of `Model.predict`.
        verbose: Whether outcomes have a line.
        before: Stamps of the files to write as they were before the run.
    """

    model: str
    how: Mapping[str, Any]
    verbose: bool
    before: Mapping[Path, _Stamp | None]

    def finished(self, item: _Item) -> Outcome | None:
        """That all files are there, if they are of this run: others are to be replaced."""
        written = [path for path in item.paths if _stamp(path) not in (None, self.before[path])]
        return Outcome(written=written) if len(written) == len(item.paths) else None

    def start(self) -> Callable[[_Item], Outcome]:
        """Loads the model."""
        from footprints_edge.model import load

        predict = partial(load(self.model, threads=1).predict, **self.how)
        return lambda item: work(predict, item.task, verbose=self.verbose)


def _stamp(path: Path) -> _Stamp | None:
    """What differs when a file has been replaced; None if there is none."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_ino, found.st_size, found.st_mtime_ns
