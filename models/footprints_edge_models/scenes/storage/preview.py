"""A contact sheet of synthetic scenes: photo, ground labels, ground depth."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from footprints_edge.drawing.colormap import colours_of
from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge_models.scenes.ground_truth.pixels import (
    BEHIND_WALL,
    FOOTPRINT,
    GROUND_ANYWHERE,
    VISIBLE_GROUND,
)
from footprints_edge_models.scenes.storage.files import SceneFile, read_scene, scene_names
from footprints_edge_models.scenes.vectors import vector

COLUMNS, ROWS = 4, 8
_TILE_PX = (200, 340)
_COLOURS = {
    "visible ground": (64, 190, 110),
    "hidden ground": (255, 225, 40),
    "footprints": (235, 60, 50),
    "behind walls": (70, 110, 235),
}

Picture = NDArray[np.uint8]


def write_preview(folder: Path, path: Path) -> None:
    """Draw some scenes of a folder, evenly spread, as a PNG.

    Raises:
        SceneFilesError: a scene is damaged, or there is none.
    """
    names = scene_names(folder)
    count = min(len(names), COLUMNS * ROWS)
    chosen = [names[k * len(names) // count] for k in range(count)] if count else []
    tiles = [_tile(read_scene(folder, name)) for name in chosen]
    blank = np.full((3 * _TILE_PX[0], _TILE_PX[1], 3), 20, np.uint8)
    rows = []
    for start in range(0, len(tiles), COLUMNS):
        row = tiles[start : start + COLUMNS]
        rows.append(np.hstack(row + [blank] * (COLUMNS - len(row))))
    sheet = Image.fromarray(np.vstack([*rows, np.full((30, rows[0].shape[1], 3), 20, np.uint8)]))
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(18)
    x = 8
    for word, colour in _COLOURS.items():
        draw.rectangle((x, sheet.height - 25, x + 18, sheet.height - 7), fill=colour)
        draw.text((x + 26, sheet.height - 16), word, (255, 255, 255), font, anchor="lm")
        x += 60 + round(font.getlength(word))
    pixels = cv2.cvtColor(np.asarray(sheet), cv2.COLOR_RGB2BGR)
    write_atomically(path, cv2.imencode(".png", pixels)[1].tobytes())


def labelled(scene: SceneFile) -> Picture:
    """The photo with its ground tinted."""
    bits = scene.ground_truth.bits
    behind = bits & BEHIND_WALL > 0
    seen = bits & VISIBLE_GROUND > 0
    picture = scene.image.astype(np.float32) * 0.75
    for word, mask in (
        ("visible ground", seen),
        ("hidden ground", (bits & GROUND_ANYWHERE > 0) & ~seen & ~behind),
        ("footprints", (bits & FOOTPRINT > 0) & ~behind),
        ("behind walls", (bits & GROUND_ANYWHERE > 0) & behind),
    ):
        picture[mask] = 0.5 * picture[mask] + 0.5 * vector(_COLOURS[word])
    return np.asarray(picture, np.uint8)


def _tile(scene: SceneFile) -> Picture:
    distance = colours_of(scene.ground_truth.ground_depth_m)
    distance[scene.ground_truth.bits & GROUND_ANYWHERE == 0] = 30
    return np.vstack([_fitted(p) for p in (scene.image, labelled(scene), distance)])


def _fitted(picture: Picture) -> Picture:
    height, width = _TILE_PX
    scale = min((height - 4) / picture.shape[0], (width - 4) / picture.shape[1])
    size = (round(picture.shape[1] * scale), round(picture.shape[0] * scale))
    tile = np.full((height, width, 3), 20, np.uint8)
    top, left = (height - size[1]) // 2, (width - size[0]) // 2
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    tile[top : top + size[1], left : left + size[0]] = small
    return tile
