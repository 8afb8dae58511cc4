"""Arrays and pictures of files from anyone: what they unpack to is bounded before it is made."""

import io
import zipfile
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from footprints_edge.inputs.images import MAX_PIXELS
from footprints_edge.inputs.pillow_warnings import without_pillow_warnings

MOST_BYTES = 2**31
"""Of the arrays of one file, unpacked."""


def read_arrays(file: Path | bytes) -> dict[str, NDArray[Any]]:
    """The arrays of an ``.npz``, a path or its bytes, by name.

    Raises:
        OSError: it cannot be read.
        ValueError: it is damaged, holds Python objects, or unpacks to more than `MOST_BYTES`.
    """
    content = io.BytesIO(file.read_bytes() if isinstance(file, Path) else file)
    try:
        with zipfile.ZipFile(content) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
        if size > MOST_BYTES:
            raise ValueError(f"it unpacks to {size} bytes")
        with np.load(content) as arrays:
            found = {name: arrays[name] for name in arrays.files}
        if odd := [name for name, array in found.items() if not isinstance(array, np.ndarray)]:
            raise ValueError(f"{odd[0]!r:.100} is no array")
        return found
    except Exception as error:  # damaged bytes make the readers raise nearly anything
        raise ValueError(f"no readable arrays: {error}") from error


def read_array(file: Path | bytes) -> NDArray[Any]:
    """The array of an ``.npy``, a path or its bytes.

    Raises:
        OSError: it cannot be read.
        ValueError: it is damaged, or holds Python objects.
    """
    content = io.BytesIO(file.read_bytes() if isinstance(file, Path) else file)
    try:  # from bytes, numpy takes memory as it fills it, whatever size is stated
        return np.asarray(np.lib.format.read_array(content, allow_pickle=False))
    except Exception as error:
        raise ValueError(f"no readable array: {error}") from error


def decode_picture(data: bytes | NDArray[np.uint8], flags: int = cv2.IMREAD_COLOR) -> NDArray[Any]:
    """The pixels of a JPEG or PNG as OpenCV delivers them: colours are BGR.

    Raises:
        ValueError: it is damaged, another kind of file, or larger than `MAX_PIXELS`.
    """
    data = bytes(data)
    try:
        with without_pillow_warnings(), Image.open(io.BytesIO(data), formats=("JPEG", "PNG")) as it:
            width, height = it.size  # OpenCV would take memory for whatever size is stated
        if width * height > MAX_PIXELS:
            raise ValueError(f"{width} x {height} pixels")
        picture = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
    except Exception as error:
        raise ValueError(f"not a readable picture: {error}") from error
    if picture is None:
        raise ValueError("not a readable picture: its pixels are damaged")
    return np.asarray(picture)


def refuse_packed(path: Path) -> None:
    """Refuses a zip that unpacks to more than it is large, where all is stored and nothing packed.

    A few megabytes would fill the memory.

    Raises:
        OSError: it cannot be read.
        ValueError: it does.
    """
    if not zipfile.is_zipfile(path):
        return
    with zipfile.ZipFile(path) as archive:
        unpacked = sum(entry.file_size for entry in archive.infolist())
    if unpacked > path.stat().st_size:
        raise ValueError(f"it unpacks to {unpacked} bytes")
