"""A progress line, redrawn in place on a terminal and silent elsewhere."""

import sys
from shutil import get_terminal_size
from time import monotonic

_BAR_WIDTH = 24


class ProgressLine:
    """A line on stderr."""

    def __init__(self, *, shown: bool, every_s: float = 0.0) -> None:
        """Prepares the line; it appears only on a terminal.

        Args:
            shown: Whether to draw at all.
            every_s: Least time between two drawings, seconds.
        """
        self._shown = shown and sys.stderr is not None and sys.stderr.isatty()
        self._every_s = every_s
        self._drawn_s = float("-inf")

    def show(self, text: str) -> None:
        """Replaces the line."""
        if self._shown and monotonic() - self._drawn_s > self._every_s:
            self._drawn_s = monotonic()
            sys.stderr.write(f"\r\x1b[K{text[: get_terminal_size().columns - 1]}")
            sys.stderr.flush()

    def clear(self) -> None:
        """Removes the line, so other output can follow."""
        if self._shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()


def bar(done: int, total: int, label: str) -> str:
    """A progress bar, the count, and a label."""
    filled = _BAR_WIDTH * done // total
    return f"{'█' * filled}{'░' * (_BAR_WIDTH - filled)} {done}/{total}  {label}"
