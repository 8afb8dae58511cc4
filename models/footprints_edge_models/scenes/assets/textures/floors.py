"""Patterns of indoor floors: wood, tiles, carpet, stone."""

import numpy as np

from footprints_edge_models.scenes.assets.textures.noise import (
    CLOTHS,
    SIDE_PX,
    STONES,
    WOODS,
    Rng,
    Texture,
    as_texture,
    cell_pattern,
    mix,
    noise,
    random_colour,
    wood_grain,
)


def planks(rng: Rng) -> Texture:
    """Boards along x, with joints."""
    rows = int(rng.integers(3, 9))
    numbers, edge_y, edge_x = cell_pattern(rng, rows, int(rng.integers(1, 3)), rng.random())
    grain = wood_grain(rng, random_colour(rng, *WOODS), rng.uniform(0.4, 1.4))
    shade = 1 + (numbers - 0.5) * rng.uniform(0.05, 0.45)
    gap = np.minimum(edge_y, edge_x) < rng.choice([0.8, 1.2, 2.0])
    return grain * (shade * np.where(gap, rng.uniform(0.35, 0.9), 1))[..., None]


def wood(rng: Rng) -> Texture:
    """One piece of wood, grain along x."""
    return wood_grain(rng, random_colour(rng, *WOODS), rng.uniform(0.3, 1.5))


def parquet(rng: Rng) -> Texture:
    """Small blocks laid in baskets."""
    side = SIDE_PX // 4
    strips = int(rng.integers(3, 6))
    grain = wood_grain(rng, random_colour(rng, *WOODS), rng.uniform(0.3, 1))
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
    grain = wood_grain(rng, random_colour(rng, *WOODS, *STONES), rng.uniform(0.2, 0.8))
    shade = (1 + rng.uniform(0.1, 0.4) * (numbers - 0.5)) * np.where(edges, 0.7, 1)
    return as_texture(grain * shade[..., None])


def tiles(rng: Rng) -> Texture:
    """Tiles with grout."""
    rows = int(rng.integers(1, 7))
    columns = rows if rng.random() < 0.7 else max(1, rows // 2)
    offset = 0.5 if columns != rows and rng.random() < 0.6 else 0.0
    numbers, edge_y, edge_x = cell_pattern(rng, rows, columns, offset)
    colour = random_colour(
        rng, (0.9, 0.9, 0.88), (0.82, 0.79, 0.72), (0.7, 0.68, 0.66), (0.93, 0.93, 0.93), *STONES
    )
    second = random_colour(rng, *STONES, (0.12, 0.12, 0.13), (0.2, 0.3, 0.45), (0.9, 0.9, 0.9))
    checked = rng.random() < 0.15
    face = np.where((numbers > 0.5)[..., None], second, colour) if checked else colour
    veins = 1 + rng.uniform(0, 0.08) * noise(rng, 1.5) + (numbers - 0.5) * rng.uniform(0, 0.12)
    grout = np.minimum(edge_y, edge_x) < rng.choice([0.9, 1.6, 2.6])
    colour_of_grout = colour * rng.uniform(0.5, 1.1)
    stone = face * veins[..., None]
    return as_texture(np.where(grout[..., None], colour_of_grout, stone))


def carpet(rng: Rng) -> Texture:
    """Pile or loops, sometimes flecked."""
    colour = random_colour(rng, *CLOTHS)
    shade = 1 + rng.uniform(0.05, 0.2) * noise(rng, 0.2) + rng.uniform(0, 0.08) * noise(rng, 1.4)
    face = colour * shade[..., None]
    if rng.random() < 0.35:
        flecks = (noise(rng, 0.4) > rng.uniform(0.8, 1.8)).astype(np.float32) * 0.7
        face = mix(face, random_colour(rng, *CLOTHS), flecks)
    if rng.random() < 0.2:
        lines = (noise(rng, 0.8, 0.02) > 0.3).astype(np.float32) * rng.uniform(0.2, 0.6)
        face = mix(face, random_colour(rng, *CLOTHS), lines)
    return as_texture(face)


def marble(rng: Rng) -> Texture:
    """Polished stone with veins or speckles."""
    colour = random_colour(
        rng, (0.9, 0.89, 0.87), (0.2, 0.2, 0.21), (0.6, 0.55, 0.5), (0.35, 0.36, 0.35)
    )
    if rng.random() < 0.5:
        veins = np.exp(-np.abs(noise(rng, 2.0)) * rng.uniform(6, 20))
        face = mix(
            np.broadcast_to(colour, (SIDE_PX, SIDE_PX, 3)), 1 - colour, veins * np.float32(0.4)
        )
    else:
        face = colour * (1 + rng.uniform(0.1, 0.3) * noise(rng, 0.5))[..., None]
    return as_texture(face)


def terrazzo(rng: Rng) -> Texture:
    """Chips in a pale ground; also vinyl."""
    ground = random_colour(rng, (0.8, 0.79, 0.76), (0.65, 0.64, 0.62), (0.45, 0.46, 0.48))
    face = np.broadcast_to(ground, (SIDE_PX, SIDE_PX, 3)).astype(np.float32)
    for _ in range(3):
        chips = (noise(rng, 1.1) > rng.uniform(1.3, 1.9)).astype(np.float32)
        face = mix(face, random_colour(rng, *STONES, *CLOTHS), chips * rng.uniform(0.3, 0.9))
    return face
