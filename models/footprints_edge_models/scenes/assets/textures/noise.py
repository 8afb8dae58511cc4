"""Tiling noise, random colours and cells: what procedural patterns are made of."""

from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

SIDE_PX = 256
Texture: TypeAlias = NDArray[np.float32]
Rng: TypeAlias = np.random.Generator


def noise(rng: Rng, roughness: float, stretch: float = 1.0, side: int = SIDE_PX) -> Texture:
    """Noise (side, side) that tiles, mean 0, deviation 1; a spectrum of 1 / f ** roughness.

    Args:
        rng: draws the noise.
        roughness: 0 is white; 1 cloudy; 2 soft.
        stretch: above 1 stretched along y, below 1 along x.
        side: side in pixels.
    """
    white = np.fft.rfft2(rng.standard_normal((side, side), dtype=np.float32))
    grey = np.fft.irfft2(white * _falloff(roughness, stretch, side), s=(side, side))
    return as_texture(grey / max(float(grey.std()), 1e-9))


@lru_cache(maxsize=100)
def _falloff(roughness: float, stretch: float, side: int) -> Texture:
    frequencies = np.fft.fftfreq(side)[:, None] ** 2 + (np.fft.rfftfreq(side) * stretch) ** 2
    frequencies[0, 0] = np.inf
    return as_texture(frequencies ** (-roughness / 2))


def as_texture(values: NDArray[Any]) -> Texture:
    """The values as float32."""
    return np.asarray(values, dtype=np.float32)


def random_colour(rng: Rng, *choices: tuple[float, float, float], spread: float = 0.06) -> Texture:
    """One of the colours, varied a little, float32 (3,)."""
    base = np.array(choices[rng.integers(len(choices))])
    colour = base * (1 + rng.normal(0, spread * 2)) + rng.normal(0, spread / 2, 3)
    return np.clip(colour, 0.02, 0.98).astype(np.float32)


def mix(first: Texture, second: Texture, share: Texture) -> Texture:
    """Blend two textures (H, W, 3) by a share (H, W): 0 gives the first, 1 the second."""
    return first + (second - first) * share[..., None]


def cell_pattern(
    rng: Rng, rows: int, columns: int, offset: float
) -> tuple[Texture, Texture, Texture]:
    """A running bond: a random number per stone, and how far a pixel is from its edges.

    Returns:
        Random numbers in [0, 1], and distances to the nearest edge along y and x, in pixels.
    """
    y, x = np.mgrid[0:SIDE_PX, 0:SIDE_PX].astype(np.float32)
    row = np.floor(y * rows / SIDE_PX)
    along = x * columns / SIDE_PX + row * offset
    column = np.floor(along) % columns
    numbers = rng.random((rows, columns)).astype(np.float32)
    edge_y = np.minimum(y * rows / SIDE_PX % 1, 1 - y * rows / SIDE_PX % 1) * SIDE_PX / rows
    edge_x = np.minimum(along % 1, 1 - along % 1) * SIDE_PX / columns
    return numbers[row.astype(int), column.astype(int)], edge_y, edge_x


WOODS = (
    (0.72, 0.56, 0.38), (0.62, 0.44, 0.27), (0.50, 0.32, 0.18), (0.36, 0.23, 0.15),
    (0.80, 0.68, 0.52), (0.66, 0.60, 0.52), (0.55, 0.50, 0.45), (0.25, 0.17, 0.12),
    (0.78, 0.60, 0.36), (0.58, 0.28, 0.16),
)  # fmt: skip
STONES = (
    (0.55, 0.54, 0.52), (0.68, 0.64, 0.58), (0.42, 0.42, 0.43), (0.75, 0.72, 0.68),
    (0.60, 0.50, 0.42), (0.30, 0.30, 0.31),
)  # fmt: skip
CLOTHS = (
    (0.50, 0.48, 0.45), (0.28, 0.30, 0.34), (0.22, 0.28, 0.42), (0.55, 0.46, 0.36),
    (0.62, 0.58, 0.52), (0.45, 0.20, 0.20), (0.22, 0.34, 0.27), (0.75, 0.72, 0.68),
    (0.18, 0.18, 0.19), (0.30, 0.42, 0.55), (0.70, 0.52, 0.30), (0.15, 0.22, 0.55),
)  # fmt: skip


def wood_grain(rng: Rng, colour: Texture, strength: float) -> Texture:
    """Wood of a colour, grain along x, float32 (SIDE_PX, SIDE_PX, 3)."""
    lines = noise(rng, 1.2, 0.06) * 0.6 + noise(rng, 1.6, 0.02) * 0.7
    rings = np.sin(lines * rng.uniform(1, 5) + noise(rng, 2.2, 0.1) * 2)
    fine = noise(rng, 0.3, 0.03)
    shade = 1 + strength * (0.10 * rings + 0.06 * fine + 0.05 * lines)
    return as_texture(colour * shade[..., None])
