"""A function of many items on a few threads, its results in the order of the items."""

import atexit
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import Future, wait
from contextlib import suppress
from functools import cache
from queue import Empty, SimpleQueue
from threading import Thread
from time import monotonic
from typing import Any, Generic, TypeAlias, TypeVar
from weakref import WeakKeyDictionary, finalize

ResultT = TypeVar("ResultT")
_Given: TypeAlias = SimpleQueue[tuple[Future[ResultT], Any] | None]


class PredictionIterator(Generic[ResultT]):
    """Results in order. An item that fails raises its error; the next call goes on after it."""

    def __init__(
        self, predict: Callable[[Any], ResultT], items: Iterable[Any], workers: int
    ) -> None:
        """Starts with the first items.

        Args:
            predict: The function, called from `workers` threads.
            items: Its arguments; at most two for each worker are taken in advance.
            workers: Number of threads.

        Raises:
            ValueError: If the number is not positive.
        """
        if workers < 1:
            raise ValueError(f"workers is {workers}; give a positive number")
        self._items = iter(items)
        self._given: _Given[ResultT] = SimpleQueue()
        self._pending: deque[Future[ResultT]] = deque()
        self._ahead = 2 * workers
        # Daemons: an item that never ends, such as a pipe that nobody writes to, must not keep the
        # program from ending.
        self._threads: list[Thread] = []
        self._predict = predict
        _join_at_exit_if_not_yet()
        for _ in range(workers):
            thread = Thread(target=_work, args=(predict, self._given), daemon=True)
            try:
                thread.start()
            except RuntimeError:  # no more are to be had, such as within `ulimit -u`
                break
            _queues[thread] = self._given
            self._threads.append(thread)
        # when nobody takes the rest
        self._no_more = finalize(self, _drop, self._given, workers)

    def __iter__(self) -> "PredictionIterator[ResultT]":
        return self

    def __next__(self) -> ResultT:
        try:
            while len(self._pending) < self._ahead:
                item, future = next(self._items), Future[ResultT]()
                self._pending.append(future)
                self._given.put((future, item))
        except StopIteration:
            if self._ahead:
                _end(self._given, len(self._threads))
            self._ahead = 0
        if not self._pending:
            raise StopIteration
        if not self._threads:
            self._given.put(None)
            _work(self._predict, self._given)
        # taken off after the wait: what Ctrl-C interrupts is still there
        wait([self._pending[0]])
        return self._pending.popleft().result()

    def stop(self, timeout_s: float) -> list[ResultT]:
        """Takes no more items.

        Args:
            timeout_s: How long to wait for those that are being worked on.

        Returns:
            Their results in order, without those that failed or are not ready.
        """
        self._ahead = 0
        self._no_more()
        running = [each for each in self._pending if not each.cancel()]
        self._pending.clear()
        wait(running, timeout_s)
        return [each.result() for each in running if each.done() and each.exception() is None]

    def close(self) -> None:
        """Takes no more items; those that are being worked on are finished."""
        self._ahead = 0
        self._no_more()
        wait([each for each in self._pending if not each.cancel()])
        self._pending.clear()
        for thread in self._threads:
            thread.join()


def _work(predict: Callable[[Any], ResultT], queue: _Given[ResultT]) -> None:
    while (given := queue.get()) is not None:
        future, item = given
        if future.set_running_or_notify_cancel():
            try:
                result = predict(item)
            except BaseException as error:  # it is raised where the result is taken
                future.set_exception(error)
            else:
                future.set_result(result)
                del result
        del given, future, item


def _drop(queue: _Given[Any], workers: int) -> None:
    """Ends the workers after what they are at; what waits is cancelled."""
    with suppress(Empty):
        while True:
            if (given := queue.get_nowait()) is not None:
                given[0].cancel()
    _end(queue, workers)


_queues: WeakKeyDictionary[Thread, _Given[Any]] = WeakKeyDictionary()
_AT_EXIT_S = 5.0


@cache
def _join_at_exit_if_not_yet() -> None:
    atexit.register(_join_all)


def _join_all() -> None:
    """A thread that comes back from an engine as the interpreter ends would abort the process."""
    until = monotonic() + _AT_EXIT_S
    begun = list(_queues.items())
    for _, queue in begun:
        _drop(queue, 1)
    for thread, _ in begun:
        thread.join(max(0.0, until - monotonic()))


def _end(queue: _Given[Any], workers: int) -> None:
    for _ in range(workers):
        queue.put(None)
