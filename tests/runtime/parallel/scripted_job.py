"""A job that worker processes can import: it writes to a log what it does, and fails or dies where
it is told to. An item's result is its square, kept in a file."""

import os
import signal
import time
from dataclasses import dataclass
from pathlib import Path

from footprints_edge.errors import FootprintsError


@dataclass(frozen=True)
class Squares:
    folder: Path
    fails_at: tuple[int, ...] = ()
    crashes_at: tuple[int, ...] = ()
    dies_at: tuple[int, ...] = ()
    dies_once_at: tuple[int, ...] = ()
    dies_late_at: tuple[int, ...] = ()
    waits_at: tuple[int, ...] = ()

    def finished(self, item):
        path = self.folder / f"{item}.txt"
        return int(path.read_text()) if path.exists() else None

    def start(self):
        self._log(f"start {os.getpid()}")
        return self._square

    def _square(self, item):
        first = item not in self.begun()
        self._log(f"{item} {os.getpid()}")
        if item in self.waits_at:
            time.sleep(120)
        if item in self.fails_at:
            raise FootprintsError(f"no file for {item}")
        if item in self.crashes_at:
            raise ZeroDivisionError("what nobody thought of")
        if item in self.dies_at or (item in self.dies_once_at and first):
            os.kill(os.getpid(), signal.SIGKILL)
        (self.folder / f"{item}.txt").write_text(str(item**2))
        if item in self.dies_late_at:
            os.kill(os.getpid(), signal.SIGKILL)
        return item**2

    def begun(self):
        """The items that were worked on, in order of beginning, repeated where they were."""
        return [int(word) for word, _ in self._lines() if word != "start"]

    def by_process(self):
        """The items that each process worked on, in order."""
        found = {}
        for word, pid in self._lines():
            if word != "start":
                found.setdefault(pid, []).append(int(word))
        return sorted(found.values())

    def pids(self):
        """The processes that began items."""
        return sorted({pid for word, pid in self._lines() if word != "start"})

    def starts(self):
        return sum(word == "start" for word, _ in self._lines())

    def _lines(self):
        path = self.folder / "log"
        return [line.split() for line in path.read_text().splitlines()] if path.exists() else []

    def _log(self, line):
        with (self.folder / "log").open("a") as log:
            log.write(f"{line}\n")
