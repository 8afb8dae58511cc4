"""A contact sheet of made pictures beside photos, and how far apart the two look."""

from collections.abc import Sequence
from pathlib import Path
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge.inputs.image_files import IMAGE_SUFFIXES
from footprints_edge.inputs.images import decode
from footprints_edge_models.scenes.storage.appearance import appearance, compare
from footprints_edge_models.scenes.storage.files import SceneFilesError, read_scene, scene_names

SHOWN = 48
"""Pictures of each kind on the sheet."""
COMPARED = 400
"""Most pictures of each kind in the numbers."""
COLUMNS = 6
_TILE_PX = (144, 224)
_GAP_PX = 12

Item = TypeVar("Item")
Picture = NDArray[np.uint8]


def write_beside_photos(
    folder: Path, photo_folders: Sequence[Path], path: Path
) -> dict[str, list[float]]:
    """Draws pictures of a folder of scenes to the left of as many photos, as a PNG.

    Args:
        folder: The scenes.
        photo_folders: Folders of photos; each gives the same share.
        path: The PNG.

    Returns:
        For each number of :class:`Appearance`: the median of made pictures, of photos, and the
        Kolmogorov-Smirnov distance of the two.

    Raises:
        SceneFilesError: A scene is damaged, or there is none, or there is no photo.
        ImageError: A photo is damaged.
    """
    names, photos = _spread(scene_names(folder), COMPARED), _photos(photo_folders)
    if not names or not photos:
        raise SceneFilesError(
            f"nothing to compare: {len(names)} scenes in {folder}, {len(photos)} photos in "
            f"{', '.join(map(str, photo_folders))}"
        )
    made = [read_scene(folder, name).image for name in names]
    real = [decode(photo).rgb for photo in photos]
    halves = [_tiled(_spread(pictures, SHOWN)) for pictures in (made, real)]
    tall = max(len(half) for half in halves)
    padded = [np.pad(half, ((0, tall - len(half)), (0, 0), (0, 0))) for half in halves]
    gap = np.full((tall, _GAP_PX, 3), 255, np.uint8)
    sheet = cv2.cvtColor(np.hstack([padded[0], gap, padded[1]]), cv2.COLOR_RGB2BGR)
    write_atomically(path, cv2.imencode(".png", sheet)[1].tobytes())
    return compare([appearance(each) for each in made], [appearance(each) for each in real])


def _photos(folders: Sequence[Path]) -> list[Path]:
    """Photos of each folder in turn."""
    found = [
        _spread(
            sorted(p for p in folder.rglob("*") if p.suffix.lower() in IMAGE_SUFFIXES),
            COMPARED // len(folders),
        )
        for folder in folders
    ]
    longest = max((len(each) for each in found), default=0)
    return [each[k] for k in range(longest) for each in found if k < len(each)]


def _spread(items: Sequence[Item], most: int) -> list[Item]:
    """Some of the items, evenly spread."""
    count = min(len(items), most)
    return [items[k * len(items) // count] for k in range(count)]


def _tiled(pictures: Sequence[Picture]) -> Picture:
    height, width = _TILE_PX
    rows = -(-len(pictures) // COLUMNS)
    sheet = np.zeros((rows * height, COLUMNS * width, 3), np.uint8)
    for number, picture in enumerate(pictures):
        scale = min((height - 2) / picture.shape[0], (width - 2) / picture.shape[1])
        size = (round(picture.shape[1] * scale), round(picture.shape[0] * scale))
        small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
        top = number // COLUMNS * height + (height - size[1]) // 2
        left = number % COLUMNS * width + (width - size[0]) // 2
        sheet[top : top + size[1], left : left + size[0]] = small
    return sheet
