"""A progress bar on a terminal; nothing anywhere else."""

import sys
from shutil import get_terminal_size

_BAR_WIDTH = 24


class Progress:
    """One line on stderr, redrawn in place."""

    def __init__(self, total: int, *, quiet: bool) -> None:
        """Draws only for more than one picture, and only on a terminal."""
        self._total = total
        self._shown = total > 1 and not quiet and sys.stderr.isatty()

    def show(self, done: int, label: str) -> None:
        """Draws how many pictures are done and which one is next."""
        if self._shown:
            filled = _BAR_WIDTH * done // self._total
            bar = "█" * filled + "░" * (_BAR_WIDTH - filled)
            line = f"{bar} {done}/{self._total}  {label}"
            sys.stderr.write(f"\r\x1b[K{line[: get_terminal_size().columns - 1]}")
            sys.stderr.flush()

    def clear(self) -> None:
        """Makes room for another line of output."""
        if self._shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
