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

logger = logging.getLogger(__name__)

TEXTURE_PX = 256
"""Longest side of a model's texture: as the library of textures has them."""
TEXTURE_QUALITY = 80
_EXPECTED = 0.55
"""What is left of a model's bytes; measured on 95 models."""
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
        AssetError: not even a tenth of the models fit.
    """
    opened = AssetPack(pack)
    kept = {(entry.kind, entry.key) for entry in opened.entries if entry.split == "train"}
    with zipfile.ZipFile(pack) as archive:
        size = {info.filename: info.file_size for info in archive.infolist()}
        models = sorted(
            (key for kind, key in kept if kind == "model"),
            key=lambda key: size[f"models/{key}.npz"],
        )
        most = len(models)
        total = sum(size[f"models/{key}.npz"] for key in models)
        while total * _EXPECTED > most_bytes:
            most -= 1
            total -= size[f"models/{models[most]}.npz"]
        while True:
            wanted = kept - {("model", key) for key in models[most:]}
            data = _compressed(_slim(archive, wanted))
            logger.info("%d of %d models: %.1f MB", most, len(models), len(data) / 1e6)
            if len(data) <= most_bytes:
                break
            if most <= len(models) // 10:
                raise AssetError(f"{pack}: its assets take more than {most_bytes / 1e6:.1f} MB")
            excess = (len(data) - most_bytes) / _EXPECTED
            while most and excess > 0:
                most -= 1
                excess -= size[f"models/{models[most]}.npz"]
    write_atomically(path, data)
    return len(wanted)


def _slim(archive: zipfile.ZipFile, wanted: set[tuple[str, str]]) -> bytes:
    """The pack with these assets alone, uncompressed."""
    index: dict[str, Any] = json.loads(archive.read(_INDEX))
    index["entries"] = [
        facts for facts in index["entries"] if (facts["kind"], facts["key"]) in wanted
    ]
    names = {f"{kind}s/{key}" for kind, key in wanted}
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as slim:
        for name in archive.namelist():
            if name.rpartition(".")[0] in names:
                data = archive.read(name)
                slim.writestr(name, _slim_arrays(data) if name.endswith(".npz") else data)
        slim.writestr(_INDEX, json.dumps(index))
    return buffer.getvalue()


def _slim_arrays(data: bytes) -> bytes:
    with np.load(io.BytesIO(data)) as arrays:
        slim = {name: arrays[name] for name in arrays.files}
    for name, array in slim.items():
        number = name.removeprefix("texture")
        # a texture with holes keeps the size that its holes have
        if number.isdecimal() and f"alpha{number}" not in slim:
            slim[name] = _slim_texture(array)
    buffer = io.BytesIO()
    np.savez(buffer, **slim)
    return buffer.getvalue()


def _slim_texture(jpeg: NDArray[np.uint8]) -> NDArray[np.uint8]:
    texture = cv2.imdecode(jpeg, cv2.IMREAD_COLOR)
    scale = TEXTURE_PX / max(texture.shape[:2])
    if scale < 1:
        texture = cv2.resize(texture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    data = cv2.imencode(".jpg", texture, [cv2.IMWRITE_JPEG_QUALITY, TEXTURE_QUALITY])[1].ravel()
    return np.asarray(data if len(data) < len(jpeg) else jpeg, np.uint8)


def _compressed(data: bytes) -> bytes:
    """With a dictionary as large as the pack, so that equal parts far apart are found."""
    filters = [{"id": lzma.FILTER_LZMA2, "preset": 6, "dict_size": 1 << 27}]
    return lzma.compress(data, format=lzma.FORMAT_XZ, filters=filters)
