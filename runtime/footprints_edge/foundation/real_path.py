"""Where a path leads."""

import os
from pathlib import Path


def real_path(path: Path) -> Path:
    """The path without links; of a link that leads to itself, the path.

    `Path.resolve` raises there, before Python 3.13 a RuntimeError.
    """
    return Path(os.path.realpath(path))
