"""Skies: sun, clouds, and what stands at the horizon."""

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.assets.textures.photographed import PackPictures
from footprints_edge_models.scenes.layout.panoramas import colours_in, heading_of, panorama
from footprints_edge_models.scenes.layout.scene import Backdrop, Colour, Sky
from footprints_edge_models.scenes.vectors import vector


def _colour(values: NDArray[np.float64]) -> Colour:
    red, green, blue = (float(v) for v in values)
    return red, green, blue


def _towards(heading: float, height: float) -> NDArray[np.float64]:
    """The unit direction (3,) of a heading and a height above the horizon, radians."""
    return np.array(
        [np.cos(heading) * np.cos(height), np.sin(heading) * np.cos(height), np.sin(height)]
    )


PANORAMAS_SHARE = 0.75
"""Share of skies that are panoramas, where the library has some."""


def draw_sky(palette: Palette, bright: float) -> Sky:
    """A sky whose horizon is about as bright as ``bright`` white walls in ordinary light."""
    rng = palette.rng
    pictures = palette.library.pictures
    if pictures is not None and pictures.panoramas and rng.random() < PANORAMAS_SHARE:
        return _photographed_sky(palette, pictures, bright)
    height = np.radians(rng.uniform(12, 70))
    heading = rng.uniform(0, 2 * np.pi)
    clear = rng.random() < 0.6
    blue = rng.uniform(0.2, 1.0) if clear else rng.uniform(0, 0.25)
    horizon = np.array([1 - 0.15 * blue, 1 - 0.06 * blue, 1.0]) * bright
    zenith = (
        np.array([1 - 0.72 * blue, 1 - 0.48 * blue, 1 - 0.12 * blue]) * bright * rng.uniform(0.6, 1)
    )
    low = 1 - np.sin(height)
    sun = (
        np.array([1.0, 1 - 0.22 * low, 1 - 0.42 * low])
        * (rng.uniform(1.2, 3.5) if clear else 0)
        * bright
    )
    far = (
        rng.uniform(0.08, 0.3)
        * np.array([0.8, 0.9, 0.7] if rng.random() < 0.6 else [1, 0.95, 0.95])
        * bright
    )
    return Sky(
        _towards(heading, height),
        _colour(sun),
        _colour(zenith),
        _colour(horizon),
        _colour(far),
        float(rng.uniform(1.5, 9)),
        palette.library.any_of(rng, "clouds"),
    )


def _photographed_sky(palette: Palette, pictures: PackPictures, bright: float) -> Sky:
    """A panorama, turned at random; where it shows the sun, the sun shines from there."""
    rng = palette.rng
    key = pictures.panoramas[rng.integers(len(pictures.panoramas))]
    seen = panorama(pictures, key)
    turn, mirrored = float(rng.uniform(0, 2 * np.pi)), bool(rng.random() < 0.5)
    grey = float(vector([0.25, 0.6, 0.15]) @ (0.5 * seen.horizon + 0.5 * seen.zenith))
    mean = (0.5 * seen.horizon + 0.5 * seen.zenith).astype(np.float64)
    paler = (grey / mean) ** 0.5  # skies at dusk and dawn are many among panoramas
    tint = bright * rng.uniform(0.75, 1.15) / grey * paler * np.exp(rng.normal(0, 0.03, 3))
    zenith, horizon, far = (
        each.astype(np.float64) * tint for each in (seen.zenith, seen.horizon, seen.far)
    )
    azimuth, height = seen.sun or (0.0, 0.8)
    heading = heading_of(azimuth, turn, mirrored=mirrored)
    low = 1 - np.sin(height)
    warm = np.array([1.0, 1 - 0.2 * low, 1 - 0.4 * low])
    sun = warm * (rng.uniform(1.5, 4.5) if seen.sun else 0) * bright
    backdrop = Backdrop(key, turn, mirrored, _colour(tint))
    return Sky(
        _towards(heading, height),
        _colour(sun),
        _colour(zenith),
        _colour(horizon),
        _colour(far),
        0.0,
        palette.library.any_of(rng, "clouds"),
        backdrop,
    )


def sky_colours(
    sky: Sky, directions: NDArray[np.float32], library: TextureLibrary
) -> NDArray[np.float32]:
    """Colours of the sky and the horizon in unit directions (N, 3): float32 (N, 3)."""
    if sky.backdrop is not None and library.pictures is not None:
        back = sky.backdrop
        seen = panorama(library.pictures, back.panorama)
        return colours_in(seen, directions, back.turn, mirrored=back.mirrored) * vector(back.tint)
    cover = library.draw(sky.clouds)[..., 0].astype(np.float32) / 255
    rise = directions[:, 2]
    up = np.clip(rise, 0, 1)[:, None]
    zenith, horizon = vector(sky.zenith), vector(sky.horizon)
    colours = horizon + (zenith - horizon) * np.clip(up * 2.2, 0, 1) ** 0.7
    # clouds lie on a plane above
    scale = 90 / np.maximum(rise, 0.06)
    column = ((directions[:, 0] * scale).astype(np.int64)) % cover.shape[1]
    row = ((directions[:, 1] * scale).astype(np.int64)) % cover.shape[0]
    share = cover[row, column][:, None] * np.clip(up * 6, 0, 1)
    colours = colours + (horizon * 1.05 - colours) * share
    # a jagged skyline, of trees and houses
    heading = ((np.arctan2(directions[:, 1], directions[:, 0]) / (2 * np.pi) % 1) * 2047).astype(
        np.int64
    )
    line = (
        np.interp(np.linspace(0, 255, 2048), np.arange(256), cover[17] - 0.5 * cover[90]) * 0.8
        + 0.55
    )
    fine = (cover[33, np.arange(2048) // 2 % 256] - 0.5) * 0.25
    top = np.sin(np.radians(sky.far_deg)) * np.clip(line + fine, 0.2, 1.5)
    shade = 0.75 + 0.5 * cover[(rise * 900).astype(np.int64) % 256, heading // 3 % 256]
    far = vector(sky.far) * shade[:, None] + 0.15 * horizon
    return np.where((rise < top[heading])[:, None], far, colours).astype(np.float32)
