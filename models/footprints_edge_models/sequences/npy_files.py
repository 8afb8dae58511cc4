"""Arrays in ``.npy`` files, in a folder or in a zip that stays packed."""

import io
import zlib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.sequences.sequence import SequenceError


@dataclass(frozen=True)
class NpyFile:
    """One array of a published data set; nothing is opened until it is wanted.

    Attributes:
        root: a folder, or a ``.zip`` file with the same inside; a folder that the zip wraps
            around everything does not count.
        name: path below the root, with slashes.
    """

    root: Path
    name: str

    def exists(self) -> bool:
        """Whether the file is there."""
        if self.root.suffix == ".zip":
            return self._inner_name() is not None
        return (self.root / self.name).is_file()

    def read(self) -> NDArray[Any]:
        """The array as it was saved.

        Raises:
            SequenceError: it is missing, damaged, or holds Python objects.
        """
        try:
            if self.root.suffix != ".zip":
                return np.asarray(np.load(self.root / self.name))
            inner = self._inner_name()
            if inner is None:
                raise FileNotFoundError("not in the zip")
            return np.asarray(np.load(io.BytesIO(_opened(self.root).read(inner))))
        except (OSError, ValueError, EOFError, BadZipFile, zlib.error) as error:
            raise SequenceError(f"{self.root / self.name}: no readable array ({error})") from error

    def _inner_name(self) -> str | None:
        archive, wrapping = _opened(self.root), _wrapping_folder(self.root)
        for name in (self.name, wrapping + self.name):
            if name in archive.NameToInfo:
                return name
        return None


@dataclass(frozen=True)
class FirstChannel:
    """Published ground segmentation: (1, h, w), probabilities."""

    file: NpyFile

    def read(self) -> NDArray[np.float32]:
        """Probability of ground, float32 (h, w)."""
        array = self.file.read()
        if array.ndim != 3:
            raise SequenceError(
                f"{self.file.root / self.file.name}: (1, h, w) is expected, not {array.shape}"
            )
        return np.asarray(array[0], np.float32)


@lru_cache(maxsize=4)
def _opened(path: Path) -> ZipFile:
    """Opened once a process: the published zips list some hundred thousand files."""
    try:
        return ZipFile(path)
    except (OSError, BadZipFile) as error:
        raise SequenceError(f"{path}: no readable zip ({error})") from error


@lru_cache(maxsize=4)
def _wrapping_folder(path: Path) -> str:
    """The one folder that holds everything in a zip, with its slash; empty where there is none."""
    tops = {name.split("/", 1)[0] for name in _opened(path).NameToInfo}
    return f"{tops.pop()}/" if len(tops) == 1 else ""
