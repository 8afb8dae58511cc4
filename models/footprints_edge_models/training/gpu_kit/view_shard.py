"""Views in one compact file: a zip of JPEGs, labels and depths as PNGs, and an index.

A depth is stored as the logarithm of metres in steps of 0.7 %: planes stay smooth, and PNG packs
them well.
"""

import json
import zipfile
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.bounded_files import decode_picture, refuse_packed
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.training.gpu_kit.stored_view import StoredView

INDEX = "views.json"
LEVELS = 1023
NEAREST_M, FARTHEST_M = 0.1, 100.0
_SPAN = float(np.log(FARTHEST_M / NEAREST_M))


@dataclass(frozen=True)
class ShardView:
    """A view of a shard: the data set it comes from, and whether it is trained on."""

    view: StoredView
    dataset: str
    split: Literal["train", "held out"]


def write_shard(path: Path, views: Iterable[ShardView], quality: int = 90) -> dict[str, int]:
    """Writes views, one after the other; the bytes that each data set takes.

    Args:
        path: The file.
        views: Not all in memory at once.
        quality: Of the JPEGs.
    """
    index: list[list[object]] = []
    taken: dict[str, int] = {}
    part = path.with_suffix(".part")
    with zipfile.ZipFile(part, "w", zipfile.ZIP_STORED) as archive:
        for number, each in enumerate(views):
            files = _encoded(each.view, quality)
            for suffix, data in files.items():
                archive.writestr(f"{number:06d}{suffix}", data)
            size = sum(map(len, files.values()))
            taken[each.dataset] = taken.get(each.dataset, 0) + size
            index.append([each.dataset, each.split, *each.view.intrinsics])
        archive.writestr(INDEX, json.dumps(index))
    part.replace(path)
    return taken


def read_shard(path: Path, threads: int = 4) -> list[ShardView]:
    """All views of a shard, in order.

    Raises:
        DatasetError: it is damaged.
    """
    try:
        refuse_packed(path)  # shards are stored
        with zipfile.ZipFile(path) as archive:
            index = json.loads(archive.read(INDEX))
            if not isinstance(index, list):
                raise ValueError(f"{INDEX} is no list")
            data = [
                [archive.read(f"{number:06d}{suffix}") for suffix in (".jpg", ".png", ".d.png")]
                for number in range(len(index))
            ]
        with ThreadPoolExecutor(threads) as pool:
            return list(pool.map(_decoded, index, data))
    except Exception as error:  # damaged bytes make the readers raise nearly anything
        raise DatasetError(
            f"{path}: no readable views ({error!r:.300}); make the kit again"
        ) from error


def _encoded(view: StoredView, quality: int) -> dict[str, bytes]:
    rgb, labels = view.pixels[..., :3], view.pixels[..., 3]
    depth_m = view.depths_m.astype(np.float32)
    steps = 1 + np.log(np.maximum(depth_m, NEAREST_M) / NEAREST_M) / _SPAN * (LEVELS - 1)
    levels = np.where(depth_m > 0, np.clip(np.rint(steps), 1, LEVELS), 0).astype(np.uint16)
    stacked = np.vstack([levels[..., 0], levels[..., 1]])
    best = [cv2.IMWRITE_PNG_COMPRESSION, 9]
    bgr = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2BGR)
    return {
        ".jpg": cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes(),
        ".png": cv2.imencode(".png", np.ascontiguousarray(labels), best)[1].tobytes(),
        ".d.png": cv2.imencode(".png", stacked, best)[1].tobytes(),
    }


def _decoded(facts: list[Any], data: list[bytes]) -> ShardView:
    picture, labels, stacked = (decode_picture(each, cv2.IMREAD_UNCHANGED) for each in data)
    height, width = labels.shape
    if picture.shape != (height, width, 3) or stacked.shape != (2 * height, width):
        raise ValueError(f"pictures of one view differ in size: {picture.shape}, {labels.shape}")
    if [each.dtype.name for each in (picture, labels, stacked)] != ["uint8", "uint8", "uint16"]:
        raise ValueError("pictures of one view have other depths than they should")
    levels = np.dstack([stacked[:height], stacked[height:]]).astype(np.float32)
    depth_m = NEAREST_M * np.exp((levels - 1) / (LEVELS - 1) * _SPAN)
    dataset, split, *intrinsics = facts
    if split not in {"train", "held out"} or not isinstance(dataset, str):
        raise ValueError(f"no data set and split: {dataset!r}, {split!r}")
    Intrinsics(*intrinsics)  # refuses what no camera has
    return ShardView(
        StoredView(
            np.dstack([cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), labels]),
            np.where(levels > 0, depth_m, 0).astype(np.float16),
            (intrinsics[0], intrinsics[1], intrinsics[2], intrinsics[3]),
        ),
        dataset,
        split,
    )
