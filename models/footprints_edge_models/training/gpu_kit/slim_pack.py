"""A pack of assets made small enough to travel: the training split alone, its textures smaller.

Nothing inside is compressed: the whole file is, at the end, as one. That finds what assets share,
and takes half the bytes.
"""

import io
import json
import logging
import lzma
import zipfile
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge_models.asset_files.asset import AssetError
from footprints_edge_models.asset_files.pack import AssetPack
from footprints_edge_models.bounded_files import decode_picture, read_arrays

logger = logging.getLogger(__name__)

TEXTURE_PX = 256
"""Longest side of a model's texture: as the library of textures has them."""
TEXTURE_QUALITY = 80
_INDEX = "index.json"


def write_slim_pack(pack: Path, path: Path, most_bytes: int) -> int:
    """Writes a pack's assets of the training split, compressed with xz, as many as fit.

    The largest models are left out first.

    Args:
        pack: A pack made by ``fp-train assets``.
        path: The file, ``.xz``.
        most_bytes: Of the file.

    Returns:
        How many assets are in it.

    Raises:
        AssetError: it is damaged, or does not fit without any models.
    """
    train = {(e.kind, e.key) for e in AssetPack(pack).entries if e.split == "train"}
    with zipfile.ZipFile(pack) as archive:
        index: dict[str, Any] = json.loads(archive.read(_INDEX))
        files = {
            name: _slim_file(name, archive.read(name))
            for name in archive.namelist()
            if _asset(name) in train
        }
    # Alone, assets take a little more than together: the first guess is on the safe side.
    taken = {name: len(_compressed(data, preset=0)) for name, data in files.items()}
    models = sorted((name for name in files if _asset(name)[0] == "model"), key=taken.__getitem__)
    kept, excess = len(models), sum(taken.values()) - most_bytes
    while True:
        while kept and excess > 0:
            kept -= 1
            excess -= taken[models[kept]]
        left_out = set(models[kept:])
        data = _packed(index, {name: files[name] for name in files if name not in left_out})
        logger.info("assets: %d of %d models, %.1f MB", kept, len(models), len(data) / 1e6)
        if len(data) <= most_bytes:
            write_atomically(path, data)
            return len(files) - len(left_out)
        if not kept:
            raise AssetError(
                f"{pack}: without any models it takes {len(data) / 1e6:.1f} MB, more than "
                f"{most_bytes / 1e6:.1f}"
            )
        excess = len(data) - most_bytes


def _asset(name: str) -> tuple[str, str]:
    """Kind and key of a file in a pack."""
    kinds, _, key = name.rpartition(".")[0].partition("/")
    return kinds.removesuffix("s"), key


def _packed(index: dict[str, Any], files: dict[str, bytes]) -> bytes:
    """A pack of these files alone, compressed as one."""
    wanted = set(map(_asset, files))
    entries = [facts for facts in index["entries"] if (facts["kind"], facts["key"]) in wanted]
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as slim:
        for name, data in files.items():
            slim.writestr(name, data)
        slim.writestr(_INDEX, json.dumps(index | {"entries": entries}))
    return _compressed(buffer.getvalue(), preset=6)


def _slim_file(name: str, data: bytes) -> bytes:
    if not name.endswith(".npz"):
        return data
    try:
        return _slim_arrays(data)
    except ValueError as error:
        raise AssetError(f"{name!r:.200} is damaged ({error}); pack the assets again") from error


def _slim_arrays(data: bytes) -> bytes:
    slim = read_arrays(data)
    for name, array in slim.items():
        number = name.removeprefix("texture")
        # a texture with holes keeps the size that its holes have
        if number.isdecimal() and f"alpha{number}" not in slim:
            slim[name] = _slim_texture(array)
    buffer = io.BytesIO()
    np.savez(buffer, **slim)  # type: ignore[arg-type]
    return buffer.getvalue()


def _slim_texture(jpeg: NDArray[np.uint8]) -> NDArray[np.uint8]:
    texture = decode_picture(jpeg)
    scale = TEXTURE_PX / max(texture.shape[:2])
    if scale < 1:
        texture = cv2.resize(texture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    data = cv2.imencode(".jpg", texture, [cv2.IMWRITE_JPEG_QUALITY, TEXTURE_QUALITY])[1].ravel()
    return np.asarray(data if len(data) < len(jpeg) else jpeg, np.uint8)


def _compressed(data: bytes, preset: int) -> bytes:
    """With a dictionary as large as a pack, so that equal parts far apart are found."""
    dictionary = min(max(1 << len(data).bit_length(), 1 << 16), 1 << 27)
    filters = [{"id": lzma.FILTER_LZMA2, "preset": preset, "dict_size": dictionary}]
    return lzma.compress(data, format=lzma.FORMAT_XZ, filters=filters)
