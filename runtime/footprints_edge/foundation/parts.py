"""Unfinished files and folders: their names say whose they are, and those of dead processes go."""

import os
import re
import sys
import time
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from shutil import rmtree

_PATTERN = re.compile(r"\.fp-([0-9a-f]{8})-(\d{1,9})-(\d{1,20})-[0-9a-f]{8}\.part")
"""Machine, process, when the process started, and what tells its parts apart."""

_EARLIER = re.compile(r"\.fp-\d{1,9}-\d{1,20}\.part")
"""Of earlier versions: process and thread, on whichever machine."""
_EARLIER_AGE_S = 24 * 3600.0
"""Nobody writes at one file for so long."""

_UNKNOWN = 0
_swept: set[tuple[int, Path]] = set()
"""Processes (a fork inherits the set) and the folders that they have swept."""


def new_part(folder: Path) -> Path:
    """A name for an unfinished file or folder in `folder`, which nothing else has.

    The first time that a process asks for one there, what dead processes left is removed. The name
    is short, as that of the finished file may have the maximum length.
    """
    pid = os.getpid()
    asked = (pid, folder.absolute())
    if asked not in _swept:
        _swept.add(asked)
        remove_abandoned(folder)
    return folder / f".fp-{_machine(pid)}-{pid}-{_started(pid)}-{os.urandom(4).hex()}.part"


@contextmanager
def part_folder(folder: Path) -> Iterator[Path]:
    """A new folder in `folder`, which is removed in the end unless it was renamed.

    Raises:
        OSError: If it cannot be created.
    """
    part = new_part(folder)
    part.mkdir()
    try:
        yield part
    finally:
        rmtree(part, ignore_errors=True)


def remove_abandoned(folder: Path) -> None:
    """Removes what processes of this machine that have ended left unfinished in `folder`.

    Parts of living processes and of other machines stay, those of earlier versions for a day. A
    folder that cannot be read, and a part that cannot be removed, are no error.
    """
    machine = _machine(os.getpid())
    with suppress(OSError, ValueError):  # ValueError: a null byte in the name
        for part in folder.iterdir():
            found = _PATTERN.fullmatch(part.name)
            if found is None:
                if not (_EARLIER.fullmatch(part.name) and _is_old(part)):
                    continue
            elif found[1] != machine or _runs(int(found[2]), int(found[3])):
                continue
            if part.is_dir() and not part.is_symlink():
                rmtree(part, ignore_errors=True)
            else:
                with suppress(OSError):
                    part.unlink()


def _is_old(part: Path) -> bool:
    """Whether it was last written to more than `_EARLIER_AGE_S` ago."""
    with suppress(OSError):  # somebody else removes it
        return time.time() - part.lstat().st_mtime > _EARLIER_AGE_S
    return False


@cache
def _machine(_pid: int) -> str:
    """Where a process's number means that process: the machine, and on Linux the container.

    Found once by each process, as a fork may be in another container.
    """
    facts = [os.environ.get("COMPUTERNAME", "") if sys.platform == "win32" else os.uname().nodename]
    with suppress(OSError):
        facts.append(Path("/etc/machine-id").read_text(errors="replace"))
    with suppress(OSError):
        facts.append(str(Path("/proc/self/ns/pid").readlink()))
    with suppress(OSError):  # cards of one image have one name and one identity
        cards = sorted(Path("/sys/class/net").glob("*/device"))
        facts += [(card.parent / "address").read_text() for card in cards]
    return f"{zlib.crc32(repr(facts).encode()):08x}"


def _started(pid: int) -> int:
    """When a process started, in ticks since the machine did: a number may be given again."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_bytes()
        return int(stat.rpartition(b")")[2].split()[19])  # the name may hold anything
    except (OSError, ValueError, IndexError):  # no Linux
        return _UNKNOWN


def _runs(pid: int, started: int) -> bool:
    """Whether the process that started then may be running still."""
    now = _started(pid)
    return _is_taken(pid) and (_UNKNOWN in (started, now) or started == now)


if sys.platform == "win32":  # where `os.kill` ends the process, whatever the signal

    def _is_taken(pid: int) -> bool:
        """Whether a process may have that number."""
        import ctypes

        query_limited_information, no_such_process = 0x1000, 87
        kernel = ctypes.WinDLL("kernel32", use_last_error=True)
        kernel.OpenProcess.restype = ctypes.c_void_p
        handle = kernel.OpenProcess(query_limited_information, False, pid)
        if handle is None:
            return ctypes.get_last_error() != no_such_process
        kernel.CloseHandle(ctypes.c_void_p(handle))
        return True

else:

    def _is_taken(pid: int) -> bool:
        """Whether a process may have that number."""
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return False
        except OSError:  # it is another user's
            pass
        return True
