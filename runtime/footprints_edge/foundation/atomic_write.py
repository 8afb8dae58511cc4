"""Atomic writes: a file appears whole or not at all."""

from pathlib import Path

from footprints_edge.foundation.parts import new_part


def write_atomically(path: Path, content: bytes) -> None:
    """Writes a file beside it, see `new_part`, and renames it; creates a missing folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = new_part(path.parent)
    try:
        part.write_bytes(content)
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
