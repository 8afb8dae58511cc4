"""Pillow's warnings about odd files: one hostile EXIF block makes dozens of them."""

import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress

_IGNORED = ("ignore", None, Warning, re.compile(r"PIL\.(?#footprints_edge)"), 0)
"""As `warnings.filterwarnings` would make it, and equal to nobody else's."""


@contextmanager
def without_pillow_warnings() -> Iterator[None]:
    """Ignores them while a picture is decoded: what matters is an error or a note.

    `warnings.catch_warnings` would not do: threads that leave it in another order than they came
    leave its filters behind, and every warning of the caller's own would be shown once more.
    """
    filters = warnings.filters
    filters.insert(0, _IGNORED)  # type: ignore[attr-defined]
    try:
        yield
    finally:
        with suppress(ValueError):  # somebody has reset the filters meanwhile
            filters.remove(_IGNORED)  # type: ignore[attr-defined]
