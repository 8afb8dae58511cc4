"""A function of many items on a few threads, its results in the order of the items."""

from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, Generic, TypeVar

ResultT = TypeVar("ResultT")


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
        self._predict, self._items = predict, iter(items)
        self._pool = ThreadPoolExecutor(workers, thread_name_prefix="predict")
        self._pending: deque[Future[ResultT]] = deque()
        self._ahead = 2 * workers

    def __iter__(self) -> "PredictionIterator[ResultT]":
        return self

    def __next__(self) -> ResultT:
        try:
            while len(self._pending) < self._ahead:
                self._pending.append(self._pool.submit(self._predict, next(self._items)))
        except StopIteration:
            self._ahead = 0
            self._pool.shutdown(wait=False)
        if not self._pending:
            raise StopIteration
        return self._pending.popleft().result()

    def close(self) -> None:
        """Takes no more items; those that are being worked on are finished."""
        self._ahead = 0
        self._pending.clear()
        self._pool.shutdown(wait=True, cancel_futures=True)
