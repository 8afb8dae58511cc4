"""Work on bands of a picture, on a few threads that stay.

For functions that let go of the interpreter's lock, such as Pillow's, and take about a millisecond:
a band goes to a waiting thread in some ten microseconds.
"""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from threading import Lock
from typing import Any, TypeVar

from footprints_edge.foundation.cores import usable_cores

ResultT = TypeVar("ResultT")

_pools: dict[int, ThreadPoolExecutor] = {}
_making = Lock()


def _forget_threads() -> None:
    """For a forked process, which has none of them."""
    global _making  # noqa: PLW0603 - another thread may have held it
    _pools.clear()
    _making = Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_threads)


def bands(length: int, parts: int, multiple: int = 1) -> list[slice]:
    """At most `parts` slices of nearly equal length that cover `range(length)` in order.

    Args:
        length: At least 1.
        parts: At least 1.
        multiple: All slices but the last have a multiple of this length.
    """
    units = -(-length // multiple)
    parts = min(parts, units)
    ends = [multiple * (units * part // parts) for part in range(1, parts)] + [length]
    return [slice(start, end) for start, end in zip([0, *ends[:-1]], ends, strict=True)]


def on_bands(work: Callable[[slice], ResultT], slices: list[slice]) -> list[ResultT]:
    """The results of `work` for each slice, in order, computed at once.

    The caller's thread takes the first slice.
    """
    first, *others = slices
    futures = [_begun(work, each, len(others)) for each in others]
    return [work(first), *(future.result() for future in futures)]


def _begun(work: Callable[[slice], ResultT], each: slice, threads: int) -> Future[ResultT]:
    try:
        return _pool(threads).submit(work, each)
    except RuntimeError:  # no thread begins when the main one has ended; others may go on
        done = Future[ResultT]()
        done.set_result(work(each))
        return done


def at_once(works: Iterable[Callable[[], Any]]) -> list[Any]:
    """The results of functions, in order, computed on all cores that this process may use."""
    each = list(works)
    threads = min(usable_cores(), len(each)) or 1
    shares = [slice(first, None, threads) for first in range(threads)]
    found: list[Any] = [None] * len(each)
    for share, results in zip(
        shares, on_bands(lambda share: [work() for work in each[share]], shares), strict=True
    ):
        found[share] = results
    return found


def _pool(threads: int) -> ThreadPoolExecutor:
    with _making:
        if threads not in _pools:
            _pools[threads] = ThreadPoolExecutor(threads, thread_name_prefix="bands")
        return _pools[threads]
