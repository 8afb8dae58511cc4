"""How many pixels are decoded at once, so that many threads take no more memory than one."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Condition


class DecodingRoom:
    """Lets threads decode pictures at once as long as they are small enough together.

    A picture that is larger than the room is decoded alone.
    """

    def __init__(self, pixels: int) -> None:
        """A room of that many pixels."""
        self.pixels = pixels
        self._forget()
        if hasattr(os, "register_at_fork"):
            os.register_at_fork(after_in_child=self._forget)

    @contextmanager
    def taken(self, pixels: int) -> Iterator[None]:
        """Waits for room, and gives it back in the end."""
        with self._changed:
            self._changed.wait_for(lambda: not self._used or self._used + pixels <= self.pixels)
            self._used += pixels
        try:
            yield
        finally:
            with self._changed:
                self._used -= pixels
                self._changed.notify_all()

    def _forget(self) -> None:
        """For a forked process, which has none of the threads that have taken room."""
        self._used = 0
        self._changed = Condition()
