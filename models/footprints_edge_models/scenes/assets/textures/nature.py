"""Patterns of ground, plants and sky."""

import numpy as np

from footprints_edge_models.scenes.assets.textures.noise import (
    SIDE_PX,
    STONES,
    Rng,
    Texture,
    as_texture,
    mix,
    noise,
    random_colour,
    wood_grain,
)


def grass(rng: Rng) -> Texture:
    """Lawn to meadow, green to dry."""
    colour = random_colour(
        rng, (0.28, 0.38, 0.14), (0.36, 0.42, 0.18), (0.48, 0.46, 0.26), (0.22, 0.32, 0.12)
    )
    dry = random_colour(rng, (0.5, 0.45, 0.28), (0.42, 0.36, 0.24), (0.33, 0.4, 0.16))
    patches = np.clip(0.3 + 0.35 * noise(rng, 1.5), 0, 1)
    face = mix(np.broadcast_to(colour, (SIDE_PX, SIDE_PX, 3)), dry, patches)
    return as_texture(face * (1 + rng.uniform(0.15, 0.35) * noise(rng, 0.35))[..., None])


def soil(rng: Rng) -> Texture:
    """Bare earth, sand, gravel."""
    colour = random_colour(rng, (0.5, 0.42, 0.32), (0.62, 0.54, 0.42), (0.4, 0.33, 0.26), *STONES)
    grit = rng.uniform(0.08, 0.3) * noise(rng, 0.25)
    return as_texture(colour * (1 + grit + 0.12 * noise(rng, 1.4))[..., None])


def leaf(rng: Rng) -> Texture:
    """Leaves."""
    colour = random_colour(
        rng, (0.24, 0.36, 0.12), (0.18, 0.28, 0.10), (0.34, 0.42, 0.16), (0.42, 0.36, 0.14)
    )
    shade = 1 + 0.35 * noise(rng, 0.8)
    return as_texture(colour * shade[..., None])


def bark(rng: Rng) -> Texture:
    """Bark, grain along y."""
    face = wood_grain(
        rng, random_colour(rng, (0.35, 0.28, 0.22), (0.45, 0.4, 0.35), (0.24, 0.2, 0.17)), 2.5
    )
    return face.transpose(1, 0, 2)


def clouds(rng: Rng) -> Texture:
    """Share of cloud, grey, for the sky."""
    cover = np.clip(noise(rng, 1.8) * rng.uniform(0.2, 0.7) + rng.uniform(-0.4, 0.7), 0, 1)
    return np.repeat(cover[..., None], 3, axis=2)
