"""Patterns of things: plastic, metal, print, books, paint, skin, hair."""

import cv2
import numpy as np

from footprints_edge_models.scenes.assets.textures.noise import (
    CLOTHS,
    SIDE_PX,
    Rng,
    Texture,
    as_texture,
    noise,
    random_colour,
)


def plain(rng: Rng) -> Texture:
    """One colour: plastic, lacquer."""
    hue, saturation = rng.random(), rng.beta(1, 3)
    value = rng.uniform(0.08, 0.95)
    pixel = np.array([[[hue * 360, saturation, value]]], np.float32)
    colour = cv2.cvtColor(pixel, cv2.COLOR_HSV2RGB)[0, 0]
    return as_texture(colour * (1 + 0.02 * noise(rng, 1.2))[..., None])


def metal(rng: Rng) -> Texture:
    """Brushed or lacquered metal."""
    colour = random_colour(
        rng, (0.6, 0.6, 0.61), (0.25, 0.25, 0.26), (0.75, 0.75, 0.74), (0.4, 0.38, 0.35)
    )
    return as_texture(colour * (1 + 0.06 * noise(rng, 0.5, 0.05))[..., None])


def print_(rng: Rng) -> Texture:
    """A poster, a cover, a label: blocks, blots and lines of text."""
    face = np.broadcast_to(
        random_colour(rng, *CLOTHS, (0.92, 0.9, 0.86), spread=0.2), (SIDE_PX, SIDE_PX, 3)
    )
    face = np.ascontiguousarray(face, dtype=np.float32)
    for _ in range(int(rng.integers(1, 6))):
        x0, y0 = rng.integers(0, 200, 2)
        width, height = rng.integers(20, 180, 2)
        colour = random_colour(rng, *CLOTHS, (0.8, 0.3, 0.2), (0.9, 0.8, 0.3), spread=0.2)
        if rng.random() < 0.4:
            centre = (int(x0), int(y0))
            cv2.ellipse(
                face, centre, (int(width // 2), int(height // 2)), 0, 0, 360, colour.tolist(), -1
            )
        else:
            face[y0 : y0 + height, x0 : x0 + width] = colour
    if rng.random() < 0.6:
        ink = random_colour(rng, (0.1, 0.1, 0.1), (0.9, 0.9, 0.9))
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
        colour = random_colour(
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
    colour = random_colour(
        rng, (0.85, 0.85, 0.85), (0.08, 0.08, 0.09), (0.5, 0.51, 0.53), (0.25, 0.26, 0.28),
        (0.55, 0.06, 0.06), (0.08, 0.16, 0.4), (0.7, 0.7, 0.68), (0.1, 0.25, 0.18),
        (0.8, 0.6, 0.1), (0.35, 0.45, 0.6), spread=0.08,
    )  # fmt: skip
    return as_texture(np.broadcast_to(colour, (SIDE_PX, SIDE_PX, 3)))


def skin(rng: Rng) -> Texture:
    """Skin."""
    colour = random_colour(
        rng, (0.85, 0.66, 0.55), (0.72, 0.52, 0.4), (0.5, 0.34, 0.25), (0.35, 0.23, 0.17)
    )
    return as_texture(np.broadcast_to(colour, (SIDE_PX, SIDE_PX, 3)))


def hair(rng: Rng) -> Texture:
    """Hair."""
    colour = random_colour(
        rng, (0.12, 0.09, 0.08), (0.3, 0.2, 0.13), (0.55, 0.42, 0.25), (0.5, 0.5, 0.5)
    )
    return as_texture(colour * (1 + 0.2 * noise(rng, 0.6, 0.1))[..., None])


def blank(rng: Rng) -> Texture:
    """Plain light grey, to be tinted."""
    return as_texture(0.8 + 0.01 * noise(rng, 1.2)[..., None].repeat(3, axis=2))
