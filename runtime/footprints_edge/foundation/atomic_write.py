"""Atomic writes: a file appears whole or not at all."""

import os
from pathlib import Path
from threading import get_ident


def write_atomically(path: Path, content: bytes) -> None:
    """Writes a temporary file, .fp-….part, and renames it; creates a missing folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    # short, as the name of `path` may have the maximum length
    part = path.with_name(f".fp-{os.getpid()}-{get_ident()}.part")
    try:
        part.write_bytes(content)
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
