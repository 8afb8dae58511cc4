"""Arrays in ``.npy`` files, in a folder or in a zip that stays packed."""

import zlib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.bounded_files import MOST_BYTES, read_array
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
                return read_array(self.root / self.name)
            inner = self._inner_name()
            if inner is None:
                raise FileNotFoundError("not in the zip")
            return read_array(_unpacked(_opened(self.root), inner))
        except (OSError, ValueError, EOFError, RuntimeError, BadZipFile, zlib.error) as error:
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


def _unpacked(archive: ZipFile, name: str) -> bytes:
    size = archive.getinfo(name).file_size
    if size > MOST_BYTES:
        raise ValueError(f"it unpacks to {size} bytes")
    return archive.read(name)


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
