"""Files that appear whole or not at all."""

import os
from pathlib import Path
from threading import get_ident


def write_atomically(path: Path, content: bytes) -> None:
    """Writes a file under another name, ending in .part, first; makes its folder if need be."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".fp-{os.getpid()}-{get_ident()}.part")  # names may be at their longest
    try:
        part.write_bytes(content)
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
