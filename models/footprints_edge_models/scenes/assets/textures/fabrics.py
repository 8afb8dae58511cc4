"""Patterns of cloth, rugs and wallpaper."""

import numpy as np

from footprints_edge_models.scenes.assets.textures.noise import (
    CLOTHS,
    SIDE_PX,
    Rng,
    Texture,
    as_texture,
    mix,
    noise,
    random_colour,
)


def fabric(rng: Rng) -> Texture:
    """A weave in one colour."""
    y, x = np.mgrid[0:SIDE_PX, 0:SIDE_PX]
    weave = ((x // 2 + y // 2) % 2 - 0.5) * rng.uniform(0, 0.2)
    shade = 1 + weave + rng.uniform(0.02, 0.1) * noise(rng, 0.8)
    return as_texture(random_colour(rng, *CLOTHS) * shade[..., None])


def stripes(rng: Rng) -> Texture:
    """Stripes along x."""
    count = int(rng.integers(2, 7))
    bands = rng.integers(0, 4, count * 2)
    colours = np.stack(
        [random_colour(rng, *CLOTHS, (0.9, 0.88, 0.84), spread=0.1) for _ in range(4)]
    )
    rows = colours[bands[np.arange(SIDE_PX) * count * 2 // SIDE_PX]]
    return as_texture(rows[:, None] * (1 + 0.06 * noise(rng, 0.4))[..., None])


def checks(rng: Rng) -> Texture:
    """Two colours in squares, or a plaid."""
    count = 2 * int(rng.integers(1, 6))
    y, x = np.mgrid[0:SIDE_PX, 0:SIDE_PX] * count // SIDE_PX
    board = (x + y) % 2 if rng.random() < 0.5 else (x % 2 + y % 2) / 2
    first, second = (random_colour(rng, *CLOTHS, (0.9, 0.9, 0.88), spread=0.1) for _ in range(2))
    face = mix(np.broadcast_to(first, (SIDE_PX, SIDE_PX, 3)), second, board.astype(np.float32))
    return as_texture(face * (1 + 0.05 * noise(rng, 0.5))[..., None])


def ornament(rng: Rng) -> Texture:
    """A mirrored pattern, as of rugs and curtains."""
    quarter = noise(rng, rng.uniform(1.4, 2.2), side=SIDE_PX // 2)
    quarter = quarter + quarter.T if rng.random() < 0.5 else quarter
    field_ = np.block([[quarter, quarter[:, ::-1]], [quarter[::-1], quarter[::-1, ::-1]]])
    colours = np.stack(
        [random_colour(rng, *CLOTHS, (0.85, 0.8, 0.7), spread=0.12) for _ in range(5)]
    )
    bands = np.digitize(field_, [-0.9, -0.2, 0.3, 1.0])
    return as_texture(colours[bands] * (1 + 0.08 * noise(rng, 0.3))[..., None])


def wallpaper(rng: Rng) -> Texture:
    """A pale pattern."""
    pattern = (stripes, ornament, checks)[rng.integers(3)](rng)
    pale = random_colour(rng, (0.9, 0.88, 0.84), (0.82, 0.84, 0.82), (0.85, 0.78, 0.72))
    return mix(pattern, pale, np.full((SIDE_PX, SIDE_PX), rng.uniform(0.5, 0.85), np.float32))
