"""Graphs that an engine has optimised once, kept in the user's cache.

Optimising takes longer than loading the result. Nothing depends on the cache: a file that is not
whole, or that cannot be read or written, is as good as none.
"""

import hashlib
import os
import platform
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path

from footprints_edge.foundation.atomic_write import write_atomically

_LEAST_BYTES, _MOST_BYTES = 2**19, 2**25
"""Smaller models load in no time, and larger ones would fill the cache."""

_MOST_GRAPHS = 8
_DIGEST_BYTES = 32


def worth_keeping(model: bytes) -> bool:
    """Whether the optimised graph of a model file is to be kept.

    A file in onnxruntime's own format is optimised already. Who has no cache gets none, and no
    graph is saved in vain.
    """
    fits = _LEAST_BYTES <= len(model) <= _MOST_BYTES and model[4:8] != b"ORTM"
    return fits and _has_cache()


def cache_folder() -> Path:
    """The user's cache of this package; need not exist."""
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "footprints-edge"


def _has_cache() -> bool:
    try:
        return cache_folder().parent.is_dir()
    except (OSError, RuntimeError):  # RuntimeError: there is no home
        return False


def read_optimised(sha256: str, runtime: str) -> bytes | None:
    """The optimised graph of a model file, None if there is no whole one.

    Args:
        sha256: Hash of the model file.
        runtime: Name and version of the engine.
    """
    try:
        data = _path(sha256, runtime).read_bytes()
    except (OSError, RuntimeError):  # RuntimeError: there is no home
        return None
    digest, graph = data[:_DIGEST_BYTES], data[_DIGEST_BYTES:]
    if hashlib.sha256(graph).digest() == digest:
        return graph
    forget_optimised(sha256)
    return None


def keep_optimised(sha256: str, runtime: str, graph: bytes) -> None:
    """Keeps the optimised graph of a model file, instead of those for other engines and machines.

    Who has no cache gets none: nothing is written into a home where no program keeps anything.

    Args:
        sha256: Hash of the model file.
        runtime: Name and version of the engine.
        graph: The bytes that the engine loads.
    """
    forget_optimised(sha256)
    with suppress(OSError, RuntimeError):
        if not _has_cache():
            return
        write_atomically(_path(sha256, runtime), hashlib.sha256(graph).digest() + graph)
        kept = sorted(cache_folder().glob("*.graph"), key=lambda path: path.stat().st_mtime)
        for path in kept[:-_MOST_GRAPHS]:
            path.unlink(missing_ok=True)


def forget_optimised(sha256: str) -> None:
    """Removes what is kept of a model file."""
    with suppress(OSError, RuntimeError):
        for path in cache_folder().glob(f"{sha256}-*"):
            path.unlink(missing_ok=True)


def _path(sha256: str, runtime: str) -> Path:
    where = hashlib.sha256(f"{runtime}\n{_processor()}".encode()).hexdigest()[:16]
    return cache_folder() / f"{sha256}-{where}.graph"


@cache
def _processor() -> str:
    """What decides which instructions a graph is optimised for."""
    facts = [platform.machine(), platform.system()]
    try:
        with Path("/proc/cpuinfo").open(encoding="utf-8", errors="replace") as file:
            for line in file:
                if line.startswith(("model name", "flags", "Features", "CPU part")):
                    facts.append(line.strip())
                if not line.strip():  # one processor is enough
                    break
    except OSError:
        facts.append(platform.processor())
    return "\n".join(facts)
