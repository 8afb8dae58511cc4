"""Patterns of walls, roads and pavements."""

import numpy as np

from footprints_edge_models.scenes.assets.textures.noise import (
    SIDE_PX,
    STONES,
    Rng,
    Texture,
    as_texture,
    cell_pattern,
    noise,
    random_colour,
)


def concrete(rng: Rng) -> Texture:
    """Concrete, screed, worn plaster."""
    shade = 1 + rng.uniform(0.03, 0.12) * noise(rng, 1.6) + rng.uniform(0, 0.08) * noise(rng, 0.3)
    return as_texture(random_colour(rng, *STONES, (0.8, 0.79, 0.77)) * shade[..., None])


def asphalt(rng: Rng) -> Texture:
    """Asphalt with grit and worn places."""
    grey = rng.uniform(0.2, 0.55)
    tint = np.array([1 + rng.normal(0, 0.02), 1.0, 1 + rng.normal(0, 0.04)])
    shade = 1 + rng.uniform(0.06, 0.2) * noise(rng, 0.1) + rng.uniform(0.03, 0.12) * noise(rng, 1.7)
    face = grey * tint * shade[..., None]
    if rng.random() < 0.4:
        cracks = np.abs(noise(rng, 1.9)) < rng.uniform(0.004, 0.02)
        face = np.where(cracks[..., None], face * 0.55, face)
    return as_texture(face)


def paving(rng: Rng) -> Texture:
    """Slabs or setts."""
    rows = int(rng.integers(2, 13))
    columns = max(1, round(rows * rng.choice([0.5, 1.0, 0.66])))
    numbers, edge_y, edge_x = cell_pattern(rng, rows, columns, rng.choice([0, 0.5]))
    colour = random_colour(rng, *STONES, (0.55, 0.32, 0.26))
    shade = 1 + (numbers - 0.5) * rng.uniform(0.05, 0.35) + 0.07 * noise(rng, 0.6)
    joint = np.minimum(edge_y, edge_x) < rng.choice([1.0, 1.8])
    return as_texture(colour * (shade * np.where(joint, rng.uniform(0.5, 0.85), 1))[..., None])


def bricks(rng: Rng) -> Texture:
    """A brick wall."""
    numbers, edge_y, edge_x = cell_pattern(rng, 14, 4, 0.5)
    colour = random_colour(
        rng, (0.55, 0.28, 0.20), (0.66, 0.42, 0.30), (0.70, 0.62, 0.48), (0.42, 0.30, 0.26)
    )
    shade = 1 + (numbers - 0.5) * rng.uniform(0.15, 0.5) + 0.08 * noise(rng, 0.6)
    mortar = np.minimum(edge_y, edge_x) < 1.1
    return np.where(
        mortar[..., None], random_colour(rng, *STONES, (0.8, 0.78, 0.74)), colour * shade[..., None]
    ).astype(np.float32)


def siding(rng: Rng) -> Texture:
    """Boards one above the other, shaded at their lower edges; also blinds and shutters."""
    rows = int(rng.integers(6, 16))
    position = np.arange(SIDE_PX) * rows / SIDE_PX % 1
    shade = np.where(position < 0.12, 0.6, 0.92 + 0.12 * position)[:, None]
    colour = random_colour(
        rng, (0.85, 0.83, 0.78), (0.7, 0.72, 0.74), (0.6, 0.64, 0.55), (0.8, 0.72, 0.5),
        (0.45, 0.5, 0.58), (0.55, 0.35, 0.28),
    )  # fmt: skip
    return as_texture(colour * (shade * (1 + 0.04 * noise(rng, 1.2)))[..., None])


def plaster_colour(rng: Rng) -> Texture:
    """A colour of painted walls, float32 (3,)."""
    return random_colour(
        rng, (0.9, 0.9, 0.88), (0.86, 0.83, 0.76), (0.8, 0.82, 0.84), (0.92, 0.9, 0.85),
        (0.75, 0.74, 0.72), (0.72, 0.78, 0.7), (0.85, 0.74, 0.56), (0.6, 0.68, 0.75),
        (0.66, 0.5, 0.42), (0.45, 0.5, 0.52),
    )  # fmt: skip


def plaster(rng: Rng) -> Texture:
    """A painted wall."""
    colour = plaster_colour(rng)
    shade = 1 + rng.uniform(0, 0.02) * noise(rng, 0.6) + rng.uniform(0, 0.015) * noise(rng, 1.9)
    return as_texture(colour * shade[..., None])
