"""What a job of many items is, and how one item went.

A job is described once and pickled to every worker. It says itself which items are finished
already, so any job can be stopped, killed and started again: nothing is done twice.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Generic, Literal, Protocol, TypeVar

from footprints_edge.errors import FootprintsError

ItemT = TypeVar("ItemT")
ResultT = TypeVar("ResultT")
ItemT_contra = TypeVar("ItemT_contra", contravariant=True)
ResultT_co = TypeVar("ResultT_co", covariant=True)


class Job(Protocol[ItemT_contra, ResultT_co]):
    """Work on many items; it can be pickled."""

    def finished(self, item: ItemT_contra) -> ResultT_co | None:
        """The result of an item that is finished already, else None."""

    def start(self) -> Callable[[ItemT_contra], ResultT_co]:
        """The function that works on one item; called once per worker, before its first item."""


@dataclass(frozen=True)
class ItemOutcome(Generic[ItemT, ResultT]):
    """How one item went.

    Attributes:
        item: the item.
        state: done in this run, finished before it, or failed.
        result: its result; None where it failed.
        reason: why it failed.
    """

    item: ItemT
    state: Literal["done", "kept", "failed"]
    result: ResultT | None = None
    reason: str = ""


ReportOutcome = Callable[[ItemOutcome[ItemT, ResultT]], None]
"""Called once for every item, as soon as its outcome is known."""


class Worker(Generic[ItemT, ResultT]):
    """What a worker process keeps from item to item."""

    def __init__(self, job: Job[ItemT, ResultT]) -> None:
        """Nothing is loaded yet, so nothing can fail here."""
        self._job = job
        self._work: Callable[[ItemT], ResultT] | None = None

    def do(self, item: ItemT) -> ItemOutcome[ItemT, ResultT]:
        """Works on an item unless it is finished; raises nothing."""
        try:
            # A worker that died may have finished the item first; then this is its second try.
            if (result := self._job.finished(item)) is None:
                if self._work is None:
                    self._work = self._job.start()
                result = self._work(item)
        except (FootprintsError, OSError) as error:
            return ItemOutcome(item, "failed", reason=str(error))
        except Exception as error:  # whatever it is, the other items still get done
            return ItemOutcome(item, "failed", reason=f"{type(error).__name__}: {error}")
        return ItemOutcome(item, "done", result)


def unfinished(
    job: Job[ItemT, ResultT], items: Iterable[ItemT], report: ReportOutcome[ItemT, ResultT]
) -> list[ItemT]:
    """The items that are still to do, in order; reports the others as kept."""
    to_do = []
    for item in items:
        result = job.finished(item)
        if result is None:
            to_do.append(item)
        else:
            report(ItemOutcome(item, "kept", result))
    return to_do


def in_runs(items: list[ItemT], parts: int) -> Iterator[list[ItemT]]:
    """The items in at most ``parts`` contiguous runs, whose lengths differ by one at most."""
    parts = min(parts, len(items))
    for part in range(parts):
        # the first `len(items) % parts` runs are one longer
        length, longer = divmod(len(items), parts)
        start = part * length + min(part, longer)
        yield items[start : start + length + (part < longer)]
