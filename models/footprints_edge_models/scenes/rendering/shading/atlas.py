"""All textures of a picture in one image, which OpenCV samples."""

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.scenes.assets.textures.library import TextureKey, TextureLibrary
from footprints_edge_models.scenes.rendering.raycast import Floats32

LEVELS = 6
_LONGEST_PX = 32000
"""OpenCV samples pictures of at most 32767 pixels a side."""
_LINEAR = ((np.arange(256) / 255) ** 2.2).astype(np.float32)


class TextureAtlas:
    """All textures of a scene in one picture, each at LEVELS sizes, so that OpenCV samples them."""

    def __init__(self, keys: list[TextureKey], library: TextureLibrary) -> None:
        """Draws the textures; ``mean`` (3, T) is the linear mean colour of each, ``side`` (T,)."""
        self.row = {key: index for index, key in enumerate(dict.fromkeys(keys))}
        textures = [library.draw(key) for key in self.row]
        self.side = np.array([len(texture) for texture in textures], np.int32)
        self.top, self.left = np.zeros((2, len(textures)), np.int32)
        height = width = 0
        for side in sorted({len(texture) for texture in textures}):  # strips of each size
            of_size = np.flatnonzero(self.side == side)
            per_strip = _LONGEST_PX // (side + 2)
            strip, place = np.divmod(np.arange(len(of_size)), per_strip)
            self.top[of_size] = place * (side + 2)
            self.left[of_size] = width + strip * (2 * side + 2 * LEVELS)
            width += int(strip[-1] + 1) * (2 * side + 2 * LEVELS)
            height = max(height, min(len(of_size), per_strip) * (side + 2))
        self.pixels = np.zeros((height, width, 3), np.uint8)
        means = []
        for texture, top, left in zip(textures, self.top, self.left, strict=True):
            smaller, x = texture, int(left)
            for _ in range(LEVELS):
                tile = cv2.copyMakeBorder(smaller, 1, 1, 1, 1, cv2.BORDER_WRAP)
                self.pixels[top : top + len(tile), x : x + tile.shape[1]] = tile
                x += tile.shape[1]
                smaller = cv2.resize(smaller, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
            means.append(np.take(_LINEAR, smaller).mean(axis=(0, 1)))
        self.mean = np.array(means, np.float32).reshape(-1, 3).T

    def sample(self, row: NDArray[np.int32], uv: Floats32, level: NDArray[np.int32]) -> Floats32:
        """Linear colours (3, N) at ``uv`` (2, N), in repeats of the textures."""
        side = np.take(self.side, row)
        within = (uv - np.floor(uv)) * (side >> level).astype(np.float32) + np.float32(0.5)
        count = len(row)
        columns = 8192
        rows = -(-count // columns)
        grid_x, grid_y = np.zeros((2, rows * columns), np.float32)
        # the levels of a texture stand side by side: 2 S - 2 S / 2^level, and two pixels for each
        start = 2 * side - (2 * side >> level) + 2 * level
        np.add(within[0], start + np.take(self.left, row), out=grid_x[:count])
        np.add(within[1], np.take(self.top, row), out=grid_y[:count])
        shape = (rows, columns)
        values = cv2.remap(
            self.pixels, grid_x.reshape(shape), grid_y.reshape(shape), cv2.INTER_LINEAR
        )
        return np.asarray(np.take(_LINEAR, values.reshape(-1, 3)[:count].T))
