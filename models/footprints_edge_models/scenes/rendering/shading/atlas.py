"""All textures of a picture in one image, which OpenCV samples."""

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.scenes.assets.textures.library import TextureKey, TextureLibrary
from footprints_edge_models.scenes.assets.textures.noise import SIDE_PX
from footprints_edge_models.scenes.rendering.raycast import Floats32

LEVELS = 6
_LINEAR = ((np.arange(256) / 255) ** 2.2).astype(np.float32)
_SIDES = np.array([SIDE_PX >> level for level in range(LEVELS)], np.float32)


class TextureAtlas:
    """All textures of a scene in one picture, each at LEVELS sizes, so that OpenCV samples them."""

    def __init__(self, keys: list[TextureKey], library: TextureLibrary) -> None:
        self.row = {key: index for index, key in enumerate(dict.fromkeys(keys))}
        side = SIDE_PX + 2
        width = 2 * SIDE_PX + 2 * LEVELS
        per_strip = 32000 // side
        strips = -(-len(self.row) // per_strip)
        self.per_strip, self.width = per_strip, width
        self.pixels = np.zeros((min(len(self.row), per_strip) * side, strips * width, 3), np.uint8)
        self.start = np.cumsum([0] + [(SIDE_PX >> level) + 2 for level in range(LEVELS - 1)])
        for key, index in self.row.items():
            texture = library.draw(key)
            top, left = index % per_strip * side, index // per_strip * width
            for level in range(LEVELS):
                tile = cv2.copyMakeBorder(texture, 1, 1, 1, 1, cv2.BORDER_WRAP)
                x = left + int(self.start[level])
                self.pixels[top : top + len(tile), x : x + tile.shape[1]] = tile
                texture = cv2.resize(texture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)

    def sample(self, row: NDArray[np.int32], uv: Floats32, level: NDArray[np.int32]) -> Floats32:
        """Linear colours (3, N) at ``uv`` (2, N), in repeats of the textures."""
        within = (uv - np.floor(uv)) * _SIDES[level] + np.float32(0.5)
        count = len(row)
        columns = 8192
        rows = -(-count // columns)
        grid_x, grid_y = np.zeros((2, rows * columns), np.float32)
        strip, place = np.divmod(row, self.per_strip)
        np.add(within[0], self.start[level] + strip * self.width, out=grid_x[:count])
        np.add(within[1], place * (SIDE_PX + 2), out=grid_y[:count])
        shape = (rows, columns)
        values = cv2.remap(
            self.pixels, grid_x.reshape(shape), grid_y.reshape(shape), cv2.INTER_LINEAR
        )
        return np.asarray(np.take(_LINEAR, values.reshape(-1, 3)[:count].T))
