"""What surfaces look like from close up: procedural patterns and crops of photos.

Every texture is a square that tiles. A library holds a fixed number of each kind, and each is
drawn from its own seed, so that any process draws the same. The seeds of the two splits are
disjoint, and a photo belongs to one split by a checksum of its bytes: no texture of the test
scenes is seen in training.
"""

import zlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.inputs.image_files import IMAGE_SUFFIXES

Split: TypeAlias = Literal["train", "test"]
SPLITS: tuple[Split, ...] = get_args(Split)

SIDE_PX = 256
VARIANTS = 60
"""How many textures of each procedural kind a split has."""
TEST_PHOTOS = 8
"""One photo in this many belongs to the test split."""

Texture: TypeAlias = NDArray[np.float32]
Rng: TypeAlias = np.random.Generator


def noise(rng: Rng, roughness: float, stretch: float = 1.0, side: int = SIDE_PX) -> Texture:
    """Noise (side, side) that tiles, mean 0, deviation 1; a spectrum of 1 / f ** roughness.

    Args:
        rng: decides.
        roughness: 0 is white; 1 cloudy; 2 soft.
        stretch: above 1 drawn out along y, below 1 along x.
        side: pixels.
    """
    white = np.fft.rfft2(rng.standard_normal((side, side), dtype=np.float32))
    grey = np.fft.irfft2(white * _falloff(roughness, stretch, side), s=(side, side))
    return _kept(grey / max(float(grey.std()), 1e-9))


@lru_cache(maxsize=100)
def _falloff(roughness: float, stretch: float, side: int) -> Texture:
    frequencies = np.fft.fftfreq(side)[:, None] ** 2 + (np.fft.rfftfreq(side) * stretch) ** 2
    frequencies[0, 0] = np.inf
    return _kept(frequencies ** (-roughness / 2))


def _kept(values: NDArray[Any]) -> Texture:
    return np.asarray(values, dtype=np.float32)


def _colour(rng: Rng, *choices: tuple[float, float, float], spread: float = 0.06) -> Texture:
    base = np.array(choices[rng.integers(len(choices))])
    colour = base * (1 + rng.normal(0, spread * 2)) + rng.normal(0, spread / 2, 3)
    return np.clip(colour, 0.02, 0.98).astype(np.float32)


def _mixed(first: Texture, second: Texture, share: Texture) -> Texture:
    return first + (second - first) * share[..., None]


def _cells(rng: Rng, rows: int, columns: int, offset: float) -> tuple[Texture, Texture, Texture]:
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


def _grain(rng: Rng, colour: Texture, strength: float) -> Texture:
    lines = noise(rng, 1.2, 0.06) * 0.6 + noise(rng, 1.6, 0.02) * 0.7
    rings = np.sin(lines * rng.uniform(1, 5) + noise(rng, 2.2, 0.1) * 2)
    fine = noise(rng, 0.3, 0.03)
    shade = 1 + strength * (0.10 * rings + 0.06 * fine + 0.05 * lines)
    return _kept(colour * shade[..., None])


def planks(rng: Rng) -> Texture:
    """Boards along x, with joints."""
    rows = int(rng.integers(3, 9))
    numbers, edge_y, edge_x = _cells(rng, rows, int(rng.integers(1, 3)), rng.random())
    grain = _grain(rng, _colour(rng, *WOODS), rng.uniform(0.4, 1.4))
    shade = 1 + (numbers - 0.5) * rng.uniform(0.05, 0.45)
    gap = np.minimum(edge_y, edge_x) < rng.choice([0.8, 1.2, 2.0])
    return grain * (shade * np.where(gap, rng.uniform(0.35, 0.9), 1))[..., None]


def wood(rng: Rng) -> Texture:
    """One piece of wood, grain along x."""
    return _grain(rng, _colour(rng, *WOODS), rng.uniform(0.3, 1.5))


def parquet(rng: Rng) -> Texture:
    """Small blocks laid in baskets."""
    side = SIDE_PX // 4
    strips = int(rng.integers(3, 6))
    grain = _grain(rng, _colour(rng, *WOODS), rng.uniform(0.3, 1))
    out = np.empty_like(grain)
    contrast = rng.uniform(0.1, 0.4)
    for row in range(4):
        for column in range(4):
            at = (slice(row * side, row * side + side), slice(column * side, column * side + side))
            block = grain[at] * (1 + contrast * (rng.random() - 0.5))
            position = np.arange(side) * strips / side
            shade = 1 + contrast * (rng.random(strips)[position.astype(int)] - 0.5)
            shade = np.where(position % 1 < strips / side, shade * 0.7, shade)
            block = block * shade[:, None, None].astype(np.float32)
            out[at] = block.transpose(1, 0, 2) if (row + column) % 2 else block
    return out


def herringbone(rng: Rng) -> Texture:
    """Blocks in zigzag."""
    unit, count = SIDE_PX // 16, 4
    y, x = np.mgrid[0:SIDE_PX, 0:SIDE_PX] // unit
    phase = (x - y) % (2 * count)
    flat = phase < count
    start_x, start_y = np.where(flat, x - phase, x), np.where(flat, y, y - (phase - count))
    numbers = rng.random((64, 64)).astype(np.float32)[start_y % 16, start_x % 16]
    edges = (np.abs(np.diff(numbers, axis=0, append=numbers[:1])) > 0) | (
        np.abs(np.diff(numbers, axis=1, append=numbers[:, :1])) > 0
    )
    grain = _grain(rng, _colour(rng, *WOODS, *STONES), rng.uniform(0.2, 0.8))
    shade = (1 + rng.uniform(0.1, 0.4) * (numbers - 0.5)) * np.where(edges, 0.7, 1)
    return _kept(grain * shade[..., None])


def tiles(rng: Rng) -> Texture:
    """Tiles with grout."""
    rows = int(rng.integers(1, 7))
    columns = rows if rng.random() < 0.7 else max(1, rows // 2)
    offset = 0.5 if columns != rows and rng.random() < 0.6 else 0.0
    numbers, edge_y, edge_x = _cells(rng, rows, columns, offset)
    colour = _colour(
        rng, (0.9, 0.9, 0.88), (0.82, 0.79, 0.72), (0.7, 0.68, 0.66), (0.93, 0.93, 0.93), *STONES
    )
    second = _colour(rng, *STONES, (0.12, 0.12, 0.13), (0.2, 0.3, 0.45), (0.9, 0.9, 0.9))
    checked = rng.random() < 0.15
    face = np.where((numbers > 0.5)[..., None], second, colour) if checked else colour
    veins = 1 + rng.uniform(0, 0.08) * noise(rng, 1.5) + (numbers - 0.5) * rng.uniform(0, 0.12)
    grout = np.minimum(edge_y, edge_x) < rng.choice([0.9, 1.6, 2.6])
    colour_of_grout = colour * rng.uniform(0.5, 1.1)
    stone = face * veins[..., None]
    return _kept(np.where(grout[..., None], colour_of_grout, stone))


def carpet(rng: Rng) -> Texture:
    """Pile or loops, sometimes flecked."""
    colour = _colour(rng, *CLOTHS)
    shade = 1 + rng.uniform(0.05, 0.2) * noise(rng, 0.2) + rng.uniform(0, 0.08) * noise(rng, 1.4)
    face = colour * shade[..., None]
    if rng.random() < 0.35:
        flecks = (noise(rng, 0.4) > rng.uniform(0.8, 1.8)).astype(np.float32) * 0.7
        face = _mixed(face, _colour(rng, *CLOTHS), flecks)
    if rng.random() < 0.2:
        lines = (noise(rng, 0.8, 0.02) > 0.3).astype(np.float32) * rng.uniform(0.2, 0.6)
        face = _mixed(face, _colour(rng, *CLOTHS), lines)
    return _kept(face)


def fabric(rng: Rng) -> Texture:
    """A weave in one colour."""
    y, x = np.mgrid[0:SIDE_PX, 0:SIDE_PX]
    weave = ((x // 2 + y // 2) % 2 - 0.5) * rng.uniform(0, 0.2)
    shade = 1 + weave + rng.uniform(0.02, 0.1) * noise(rng, 0.8)
    return _kept(_colour(rng, *CLOTHS) * shade[..., None])


def stripes(rng: Rng) -> Texture:
    """Stripes along x."""
    count = int(rng.integers(2, 7))
    bands = rng.integers(0, 4, count * 2)
    colours = np.stack([_colour(rng, *CLOTHS, (0.9, 0.88, 0.84), spread=0.1) for _ in range(4)])
    rows = colours[bands[np.arange(SIDE_PX) * count * 2 // SIDE_PX]]
    return _kept(rows[:, None] * (1 + 0.06 * noise(rng, 0.4))[..., None])


def checks(rng: Rng) -> Texture:
    """Two colours in squares, or a plaid."""
    count = 2 * int(rng.integers(1, 6))
    y, x = np.mgrid[0:SIDE_PX, 0:SIDE_PX] * count // SIDE_PX
    board = (x + y) % 2 if rng.random() < 0.5 else (x % 2 + y % 2) / 2
    first, second = (_colour(rng, *CLOTHS, (0.9, 0.9, 0.88), spread=0.1) for _ in range(2))
    face = _mixed(np.broadcast_to(first, (SIDE_PX, SIDE_PX, 3)), second, board.astype(np.float32))
    return _kept(face * (1 + 0.05 * noise(rng, 0.5))[..., None])


def ornament(rng: Rng) -> Texture:
    """A mirrored pattern, as of rugs and curtains."""
    quarter = noise(rng, rng.uniform(1.4, 2.2), side=SIDE_PX // 2)
    quarter = quarter + quarter.T if rng.random() < 0.5 else quarter
    field_ = np.block([[quarter, quarter[:, ::-1]], [quarter[::-1], quarter[::-1, ::-1]]])
    colours = np.stack([_colour(rng, *CLOTHS, (0.85, 0.8, 0.7), spread=0.12) for _ in range(5)])
    bands = np.digitize(field_, [-0.9, -0.2, 0.3, 1.0])
    return _kept(colours[bands] * (1 + 0.08 * noise(rng, 0.3))[..., None])


def concrete(rng: Rng) -> Texture:
    """Concrete, screed, worn plaster."""
    shade = 1 + rng.uniform(0.03, 0.12) * noise(rng, 1.6) + rng.uniform(0, 0.08) * noise(rng, 0.3)
    return _kept(_colour(rng, *STONES, (0.8, 0.79, 0.77)) * shade[..., None])


def asphalt(rng: Rng) -> Texture:
    """Asphalt with grit and worn places."""
    grey = rng.uniform(0.2, 0.55)
    tint = np.array([1 + rng.normal(0, 0.02), 1.0, 1 + rng.normal(0, 0.04)])
    shade = 1 + rng.uniform(0.06, 0.2) * noise(rng, 0.1) + rng.uniform(0.03, 0.12) * noise(rng, 1.7)
    face = grey * tint * shade[..., None]
    if rng.random() < 0.4:
        cracks = np.abs(noise(rng, 1.9)) < rng.uniform(0.004, 0.02)
        face = np.where(cracks[..., None], face * 0.55, face)
    return _kept(face)


def paving(rng: Rng) -> Texture:
    """Slabs or setts."""
    rows = int(rng.integers(2, 13))
    columns = max(1, round(rows * rng.choice([0.5, 1.0, 0.66])))
    numbers, edge_y, edge_x = _cells(rng, rows, columns, rng.choice([0, 0.5]))
    colour = _colour(rng, *STONES, (0.55, 0.32, 0.26))
    shade = 1 + (numbers - 0.5) * rng.uniform(0.05, 0.35) + 0.07 * noise(rng, 0.6)
    joint = np.minimum(edge_y, edge_x) < rng.choice([1.0, 1.8])
    return _kept(colour * (shade * np.where(joint, rng.uniform(0.5, 0.85), 1))[..., None])


def bricks(rng: Rng) -> Texture:
    """A brick wall."""
    numbers, edge_y, edge_x = _cells(rng, 14, 4, 0.5)
    colour = _colour(
        rng, (0.55, 0.28, 0.20), (0.66, 0.42, 0.30), (0.70, 0.62, 0.48), (0.42, 0.30, 0.26)
    )
    shade = 1 + (numbers - 0.5) * rng.uniform(0.15, 0.5) + 0.08 * noise(rng, 0.6)
    mortar = np.minimum(edge_y, edge_x) < 1.1
    return np.where(
        mortar[..., None], _colour(rng, *STONES, (0.8, 0.78, 0.74)), colour * shade[..., None]
    ).astype(np.float32)


def siding(rng: Rng) -> Texture:
    """Boards one above the other, shaded at their lower edges; also blinds and shutters."""
    rows = int(rng.integers(6, 16))
    position = np.arange(SIDE_PX) * rows / SIDE_PX % 1
    shade = np.where(position < 0.12, 0.6, 0.92 + 0.12 * position)[:, None]
    colour = _colour(
        rng, (0.85, 0.83, 0.78), (0.7, 0.72, 0.74), (0.6, 0.64, 0.55), (0.8, 0.72, 0.5),
        (0.45, 0.5, 0.58), (0.55, 0.35, 0.28),
    )  # fmt: skip
    return _kept(colour * (shade * (1 + 0.04 * noise(rng, 1.2)))[..., None])


def plaster(rng: Rng) -> Texture:
    """A painted wall."""
    colour = _colour(
        rng, (0.9, 0.9, 0.88), (0.86, 0.83, 0.76), (0.8, 0.82, 0.84), (0.92, 0.9, 0.85),
        (0.75, 0.74, 0.72), (0.72, 0.78, 0.7), (0.85, 0.74, 0.56), (0.6, 0.68, 0.75),
        (0.66, 0.5, 0.42), (0.45, 0.5, 0.52),
    )  # fmt: skip
    shade = 1 + rng.uniform(0, 0.02) * noise(rng, 0.6) + rng.uniform(0, 0.015) * noise(rng, 1.9)
    return _kept(colour * shade[..., None])


def wallpaper(rng: Rng) -> Texture:
    """A pale pattern."""
    pattern = (stripes, ornament, checks)[rng.integers(3)](rng)
    pale = _colour(rng, (0.9, 0.88, 0.84), (0.82, 0.84, 0.82), (0.85, 0.78, 0.72))
    return _mixed(pattern, pale, np.full((SIDE_PX, SIDE_PX), rng.uniform(0.5, 0.85), np.float32))


def grass(rng: Rng) -> Texture:
    """Lawn to meadow, green to dry."""
    colour = _colour(
        rng, (0.28, 0.38, 0.14), (0.36, 0.42, 0.18), (0.48, 0.46, 0.26), (0.22, 0.32, 0.12)
    )
    dry = _colour(rng, (0.5, 0.45, 0.28), (0.42, 0.36, 0.24), (0.33, 0.4, 0.16))
    patches = np.clip(0.3 + 0.35 * noise(rng, 1.5), 0, 1)
    face = _mixed(np.broadcast_to(colour, (SIDE_PX, SIDE_PX, 3)), dry, patches)
    return _kept(face * (1 + rng.uniform(0.15, 0.35) * noise(rng, 0.35))[..., None])


def soil(rng: Rng) -> Texture:
    """Bare earth, sand, gravel."""
    colour = _colour(rng, (0.5, 0.42, 0.32), (0.62, 0.54, 0.42), (0.4, 0.33, 0.26), *STONES)
    grit = rng.uniform(0.08, 0.3) * noise(rng, 0.25)
    return _kept(colour * (1 + grit + 0.12 * noise(rng, 1.4))[..., None])


def leaf(rng: Rng) -> Texture:
    """Leaves."""
    colour = _colour(
        rng, (0.24, 0.36, 0.12), (0.18, 0.28, 0.10), (0.34, 0.42, 0.16), (0.42, 0.36, 0.14)
    )
    shade = 1 + 0.35 * noise(rng, 0.8)
    return _kept(colour * shade[..., None])


def bark(rng: Rng) -> Texture:
    """Bark, grain along y."""
    face = _grain(rng, _colour(rng, (0.35, 0.28, 0.22), (0.45, 0.4, 0.35), (0.24, 0.2, 0.17)), 2.5)
    return face.transpose(1, 0, 2)


def marble(rng: Rng) -> Texture:
    """Polished stone with veins or speckles."""
    colour = _colour(rng, (0.9, 0.89, 0.87), (0.2, 0.2, 0.21), (0.6, 0.55, 0.5), (0.35, 0.36, 0.35))
    if rng.random() < 0.5:
        veins = np.exp(-np.abs(noise(rng, 2.0)) * rng.uniform(6, 20))
        face = _mixed(
            np.broadcast_to(colour, (SIDE_PX, SIDE_PX, 3)), 1 - colour, veins * np.float32(0.4)
        )
    else:
        face = colour * (1 + rng.uniform(0.1, 0.3) * noise(rng, 0.5))[..., None]
    return _kept(face)


def terrazzo(rng: Rng) -> Texture:
    """Chips in a pale ground; also vinyl."""
    ground = _colour(rng, (0.8, 0.79, 0.76), (0.65, 0.64, 0.62), (0.45, 0.46, 0.48))
    face = np.broadcast_to(ground, (SIDE_PX, SIDE_PX, 3)).astype(np.float32)
    for _ in range(3):
        chips = (noise(rng, 1.1) > rng.uniform(1.3, 1.9)).astype(np.float32)
        face = _mixed(face, _colour(rng, *STONES, *CLOTHS), chips * rng.uniform(0.3, 0.9))
    return face


def plain(rng: Rng) -> Texture:
    """One colour: plastic, lacquer."""
    hue, saturation = rng.random(), rng.beta(1, 3)
    value = rng.uniform(0.08, 0.95)
    pixel = np.array([[[hue * 360, saturation, value]]], np.float32)
    colour = cv2.cvtColor(pixel, cv2.COLOR_HSV2RGB)[0, 0]
    return _kept(colour * (1 + 0.02 * noise(rng, 1.2))[..., None])


def metal(rng: Rng) -> Texture:
    """Brushed or lacquered metal."""
    colour = _colour(
        rng, (0.6, 0.6, 0.61), (0.25, 0.25, 0.26), (0.75, 0.75, 0.74), (0.4, 0.38, 0.35)
    )
    return _kept(colour * (1 + 0.06 * noise(rng, 0.5, 0.05))[..., None])


def print_(rng: Rng) -> Texture:
    """A poster, a cover, a label: blocks, blots and lines of text."""
    face = np.broadcast_to(
        _colour(rng, *CLOTHS, (0.92, 0.9, 0.86), spread=0.2), (SIDE_PX, SIDE_PX, 3)
    )
    face = np.ascontiguousarray(face, dtype=np.float32)
    for _ in range(int(rng.integers(1, 6))):
        x0, y0 = rng.integers(0, 200, 2)
        width, height = rng.integers(20, 180, 2)
        colour = _colour(rng, *CLOTHS, (0.8, 0.3, 0.2), (0.9, 0.8, 0.3), spread=0.2)
        if rng.random() < 0.4:
            centre = (int(x0), int(y0))
            cv2.ellipse(
                face, centre, (int(width // 2), int(height // 2)), 0, 0, 360, colour.tolist(), -1
            )
        else:
            face[y0 : y0 + height, x0 : x0 + width] = colour
    if rng.random() < 0.6:
        ink = _colour(rng, (0.1, 0.1, 0.1), (0.9, 0.9, 0.9))
        for row in range(
            int(rng.integers(10, 120)), int(rng.integers(130, 250)), int(rng.integers(7, 16))
        ):
            letters = rng.random(SIDE_PX // 3).repeat(3) > 0.35
            letters[:20] = False
            letters[int(rng.integers(120, 240)) :] = False
            face[row : row + 4, : letters.size][:, letters] = ink
    return face


def books(rng: Rng) -> Texture:
    """Spines side by side."""
    face = np.empty((SIDE_PX, SIDE_PX, 3), np.float32)
    x = 0
    while x < SIDE_PX:
        width = int(rng.integers(6, 26))
        colour = _colour(
            rng, *CLOTHS, (0.9, 0.88, 0.82), (0.75, 0.3, 0.2), (0.85, 0.7, 0.3), spread=0.2
        )
        top = int(rng.integers(0, 60))
        face[:top, x : x + width] = 0.05
        face[top:, x : x + width] = colour
        face[top:, x : x + 1] *= 0.5
        band = int(rng.integers(top, SIDE_PX - 20))
        face[band : band + int(rng.integers(5, 40)), x + 2 : x + width - 1] *= rng.uniform(0.5, 1.4)
        x += width
    return face


def paint(rng: Rng) -> Texture:
    """A vehicle's paint."""
    colour = _colour(
        rng, (0.85, 0.85, 0.85), (0.08, 0.08, 0.09), (0.5, 0.51, 0.53), (0.25, 0.26, 0.28),
        (0.55, 0.06, 0.06), (0.08, 0.16, 0.4), (0.7, 0.7, 0.68), (0.1, 0.25, 0.18),
        (0.8, 0.6, 0.1), (0.35, 0.45, 0.6), spread=0.08,
    )  # fmt: skip
    return _kept(np.broadcast_to(colour, (SIDE_PX, SIDE_PX, 3)))


def skin(rng: Rng) -> Texture:
    """Skin."""
    colour = _colour(
        rng, (0.85, 0.66, 0.55), (0.72, 0.52, 0.4), (0.5, 0.34, 0.25), (0.35, 0.23, 0.17)
    )
    return _kept(np.broadcast_to(colour, (SIDE_PX, SIDE_PX, 3)))


def hair(rng: Rng) -> Texture:
    """Hair."""
    colour = _colour(rng, (0.12, 0.09, 0.08), (0.3, 0.2, 0.13), (0.55, 0.42, 0.25), (0.5, 0.5, 0.5))
    return _kept(colour * (1 + 0.2 * noise(rng, 0.6, 0.1))[..., None])


def blank(rng: Rng) -> Texture:
    """Plain light grey, to be tinted."""
    return _kept(0.8 + 0.01 * noise(rng, 1.2)[..., None].repeat(3, axis=2))


def clouds(rng: Rng) -> Texture:
    """Share of cloud, grey, for the sky."""
    cover = np.clip(noise(rng, 1.8) * rng.uniform(0.2, 0.7) + rng.uniform(-0.4, 0.7), 0, 1)
    return np.repeat(cover[..., None], 3, axis=2)


KINDS: dict[str, Callable[[Rng], Texture]] = {
    function.__name__.rstrip("_"): function
    for function in (
        planks, wood, parquet, herringbone, tiles, carpet, fabric, stripes, checks, ornament,
        concrete, asphalt, paving, bricks, siding, plaster, wallpaper, grass, soil, leaf, bark,
        marble, terrazzo, plain, metal, print_, books, paint, skin, hair, blank, clouds,
    )
}  # fmt: skip


@dataclass(frozen=True)
class TextureKey:
    """One texture of a library: its kind, or ``photo``, and its number."""

    kind: str
    number: int


@dataclass(frozen=True)
class TextureLibrary:
    """The textures of one split.

    Attributes:
        split: train or test; decides the seeds.
        photos: photos of this split, whose crops are textures of the kind ``photo``.
    """

    split: Split
    photos: tuple[Path, ...] = field(default=(), repr=False)

    @classmethod
    def over(cls, split: Split, folders: Iterable[Path]) -> "TextureLibrary":
        """With the photos of these folders and those below that belong to the split.

        One photo in TEST_PHOTOS, by a checksum of its bytes, belongs to the test scenes.
        """
        found = [
            path
            for folder in folders
            for path in sorted(folder.rglob("*"))
            if path.suffix.lower() in IMAGE_SUFFIXES
        ]
        return cls(split, tuple(p for p in found if photo_split(p) == split))

    def any_of(self, rng: Rng, *kinds: str) -> TextureKey:
        """A random texture of one of these kinds; ``photo`` becomes ``print`` without photos."""
        kind = kinds[rng.integers(len(kinds))]
        number = int(rng.integers(1 << 30))
        if kind == "photo" and self.photos:
            return TextureKey("photo", number % (len(self.photos) * 4))
        return TextureKey("print" if kind == "photo" else kind, number % VARIANTS)

    def draw(self, key: TextureKey) -> NDArray[np.uint8]:
        """The texture, uint8 (SIDE_PX, SIDE_PX, 3), RGB; it tiles."""
        if key.kind == "photo":
            return _photo_crop(self.photos[key.number // 4], key.number % 4)
        return _drawn(self.split, key.kind, key.number)


def photo_split(path: Path) -> Split:
    """The split that a photo's textures belong to."""
    return "test" if zlib.crc32(path.read_bytes()) % TEST_PHOTOS == 0 else "train"


@lru_cache(maxsize=2500)
def _drawn(split: Split, kind: str, number: int) -> NDArray[np.uint8]:
    seed = (SPLITS.index(split), zlib.crc32(kind.encode()), number)
    texture = KINDS[kind](np.random.default_rng(seed))
    return (np.clip(texture, 0, 1) * 255).astype(np.uint8)


@lru_cache(maxsize=800)
def _photo_crop(path: Path, number: int) -> NDArray[np.uint8]:
    """A square crop, mirrored to both sides so that it tiles."""
    from footprints_edge.inputs.images import decode

    image = decode(path).rgb
    rng = np.random.default_rng((zlib.crc32(image.tobytes()), number))
    side = int(min(image.shape[:2]) * rng.uniform(0.25, 0.8))
    top = int(rng.integers(0, image.shape[0] - side + 1))
    left = int(rng.integers(0, image.shape[1] - side + 1))
    crop = image[top : top + side, left : left + side]
    half = cv2.resize(crop, (SIDE_PX // 2, SIDE_PX // 2), interpolation=cv2.INTER_AREA)
    row = np.hstack([half, half[:, ::-1]])
    return np.vstack([row, row[::-1]])
