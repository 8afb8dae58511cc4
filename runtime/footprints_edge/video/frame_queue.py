"""Frames that wait to be predicted: a file waits for room, a live source drops the oldest."""

from collections.abc import Callable
from queue import Empty, Full, Queue
from threading import Event
from typing import Generic, TypeVar

ItemT = TypeVar("ItemT")

QUEUE_SIZE = 2
"""Frames that may wait between two stages."""

POLL_S = 0.1
"""A waiting stage checks this often whether the others have stopped."""


class FrameQueue(Generic[ItemT]):
    """A bounded queue between a thread that makes frames and the one that takes them."""

    def __init__(
        self, *, live: bool, on_drop: Callable[[], None] = lambda: None, size: int = QUEUE_SIZE
    ) -> None:
        """Makes an empty queue.

        Args:
            live: Whether the source cannot wait: the oldest frame makes room for a new one.
            on_drop: Called for every frame that is dropped.
            size: Frames that may wait.
        """
        self._queue: Queue[ItemT] = Queue(size)
        self._live, self._on_drop = live, on_drop
        self._stopped = Event()

    @property
    def stopped(self) -> bool:
        """Whether no more frames are wanted."""
        return self._stopped.is_set()

    def put(self, frame: ItemT) -> None:
        """Adds a frame, as soon as there is room; not after `stop`."""
        while not self.stopped:
            try:
                self._queue.put(frame, timeout=0 if self._live else POLL_S)
                return
            except Full:
                if self._live:
                    self._drop_oldest()

    def _drop_oldest(self) -> None:
        try:
            self._queue.get_nowait()
        except Empty:  # it has just been taken
            return
        self._on_drop()

    def get(self, ended: Callable[[], bool]) -> ItemT | None:
        """The next frame; None after the last one, or after `stop`.

        Args:
            ended: Whether no more frames will be added.
        """
        while not self.stopped:
            last = ended()  # before the queue is looked into: what was added before it is there
            try:
                return self._queue.get(timeout=0 if last else POLL_S)
            except Empty:
                if last:
                    return None
        return None

    def stop(self) -> None:
        """No more frames are wanted; whoever waits returns."""
        self._stopped.set()
