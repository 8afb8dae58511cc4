"""Where a path leads."""

import os
from pathlib import Path


def real_path(path: Path) -> Path:
    """The path without links; of a link that leads to itself, or a name with a null byte, the path.

    `Path.resolve` raises there, before Python 3.13 a RuntimeError.
    """
    try:
        return Path(os.path.realpath(path))
    except ValueError:  # a null byte: there is no such file, as whoever opens it will say
        return path
