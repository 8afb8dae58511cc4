"""Panoramas as skies: their colours by direction, and the sun in them."""

from dataclasses import dataclass, field
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.scenes.assets.textures.photographed import PackPictures
from footprints_edge_models.scenes.vectors import vector

_LINEAR = ((np.arange(256) / 255) ** 2.2).astype(np.float32)
_HIGHEST_SUN_DEG, _LOWEST_SUN_DEG = 72, 6
_LARGEST_SUN = 0.05
"""Where more of the upper half than this is as bright as the sun, clouds hide it."""


@dataclass(frozen=True)
class Panorama:
    """A panorama's picture and what it says of light. North is its left edge.

    Attributes:
        picture: uint8 (H, 2 H, 3), RGB; the horizon is its middle row.
        zenith: mean linear colour above 40 degrees, (3,).
        horizon: mean linear colour from 4 to 30 degrees, (3,).
        far: mean linear colour from 0 to 4 degrees, (3,).
        sun: (azimuth, elevation) of the sun in radians; None where none is seen.
    """

    picture: NDArray[np.uint8] = field(repr=False)
    zenith: NDArray[np.float32]
    horizon: NDArray[np.float32]
    far: NDArray[np.float32]
    sun: tuple[float, float] | None


@lru_cache(maxsize=32)
def panorama(pictures: PackPictures, key: str) -> Panorama:
    """A panorama of a pack, looked through once."""
    picture = pictures.panorama(key)
    rows = len(picture)
    linear = _LINEAR[picture]
    soft = cv2.GaussianBlur(linear[: rows // 2] @ vector([0.25, 0.6, 0.15]), (0, 0), rows / 80)

    def mean(low_deg: float, high_deg: float) -> NDArray[np.float32]:
        first, last = (round((0.5 - deg / 180) * rows) for deg in (high_deg, low_deg))
        return np.asarray(linear[first:last].mean(axis=(0, 1)), np.float32)

    row, column = np.unravel_index(int(soft.argmax()), soft.shape)
    elevation = np.pi * (0.5 - (row + 0.5) / rows)
    shows = (
        soft[row, column] > 0.9
        and (soft > 0.9).mean() < _LARGEST_SUN
        and _LOWEST_SUN_DEG < np.degrees(elevation) < _HIGHEST_SUN_DEG
    )
    sun = (float(np.pi * (column + 0.5) / rows), float(elevation)) if shows else None
    return Panorama(picture, mean(40, 90), mean(4, 30), mean(0, 4), sun)


def colours_in(
    seen: Panorama, directions: NDArray[np.float32], turn: float, *, mirrored: bool
) -> NDArray[np.float32]:
    """Linear colours (N, 3) of a turned panorama in unit directions (N, 3).

    What the camera of the panorama has clipped is brighter than it shows.
    """
    if not len(directions):
        return np.zeros((0, 3), np.float32)
    rows = len(seen.picture)
    azimuth = np.arctan2(directions[:, 1], directions[:, 0]) * (-1 if mirrored else 1) - turn
    x = (azimuth / (2 * np.pi) % 1 * (2 * rows)).astype(np.float32)
    y = ((0.5 - np.arcsin(np.clip(directions[:, 2], -1, 1)) / np.pi) * rows).astype(np.float32)
    count, columns = len(x), 4096
    grid = np.zeros((2, -(-count // columns) * columns), np.float32)
    grid[:, :count] = np.stack([x, y]) - np.float32(0.5)
    grid_x, grid_y = grid.reshape(2, -1, columns)
    found = cv2.remap(seen.picture, grid_x, grid_y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_WRAP)
    colours = np.take(_LINEAR, found.reshape(-1, 3)[:count])
    return np.asarray(colours * (1 + 2 * colours**8), np.float32)


def heading_of(azimuth: float, turn: float, *, mirrored: bool) -> float:
    """The heading in the world, radians, of an azimuth in a panorama that was turned."""
    return (azimuth + turn) * (-1 if mirrored else 1)
