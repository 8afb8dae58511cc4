"""Light on surfaces: lamps, sun, and the light from everywhere, with soft shadows."""

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Size
from footprints_edge_models.scenes.layout.scene import Lamp, Scene
from footprints_edge_models.scenes.rendering.raycast import Floats32, Triangles
from footprints_edge_models.scenes.rendering.shading.bounced import SecondLight
from footprints_edge_models.scenes.rendering.shading.lamps import (
    lamp_gains,
    lamp_hues,
    strongest_lamps,
)
from footprints_edge_models.scenes.rendering.shading.on_surfaces import (
    Keys,
    means,
    refined,
    surface_keys,
    with_neighbours,
)
from footprints_edge_models.scenes.rendering.shading.surfaces import Surface
from footprints_edge_models.scenes.vectors import dot, vector


def _pattern(
    size: Size, asked: NDArray[np.int64], count: int, rng: np.random.Generator
) -> Floats32:
    """Random numbers (count, M) in [0, 1) for some pixels, stratified over each 3 x 3 block."""
    order = rng.permuted(np.tile(np.arange(9), (count, 1)), axis=1)
    jitter = rng.random((size[0] * size[1], count), dtype=np.float32)
    place = np.take(order, _place(asked, size[1]), axis=1)
    return np.asarray((place + jitter[asked].T) / 9, dtype=np.float32)


def _place(pixels: NDArray[np.int64], width: int) -> NDArray[np.int64]:
    """The place of each pixel in its block of 3 x 3."""
    row, column = np.divmod(pixels, width)
    return np.asarray(row % 3 * 3 + column % 3)


def light_on(
    scene: Scene,
    solids: Triangles,
    surface: Surface,
    size: Size,
    rng: np.random.Generator,
    second: SecondLight | None = None,
) -> Floats32:
    """Light on every point, (3, N).

    Rays are traced for every second pixel, as on a chessboard, or along each side where they bring
    the light of the surroundings; filters fill the others.

    Args:
        scene: the scene.
        solids: ray tracer of all triangles.
        surface: the points.
        size: (H, W) of the picture that they make.
        rng: draws where rays go.
        second: the light of the sky and of other surfaces; without it the scene's ambient light,
            less where little of the surroundings is open.
    """
    step = 1 if second is None else 2
    traced = (-(-size[0] // step), -(-size[1] // step))
    pixels = np.arange(size[0] * size[1]).reshape(size)[::step, ::step].ravel()
    rows, columns = np.ogrid[: traced[0], : traced[1]]
    some = np.ones(traced, np.bool_) if second else (rows + columns) % 2 == 0
    cells = np.flatnonzero(some.ravel() & surface.met[pixels])
    if second is not None:  # rays of one stratum go about the same way: they are traced faster
        cells = cells[np.argsort(_place(cells, traced[1]), kind="stable")]
    asked = pixels[cells]
    dice = _pattern(traced, cells, 5, rng)
    normals = surface.normals
    points_asked, normals_asked = (np.take(v, asked, axis=1) for v in (surface.points, normals))
    lamps = strongest_lamps(scene.lamps, points_asked)
    away = _around(normals_asked, dice[:2])
    if second is None:
        reach_m = 0.9 if scene.kind == "rooms" else 2.0
        around = _openness(solids, points_asked, away, reach_m)[None]
    else:
        around = second.along(points_asked, away, lamps)
    shares = np.zeros((len(around) + 3, traced[0] * traced[1]), np.float32)
    shares[-1, cells] = 1
    shares[:-3, cells] = around
    sun = vector(scene.sky.sun)
    towards = scene.sky.towards_sun.astype(np.float32)
    falls = np.maximum(towards @ normals, 0)
    lit = np.flatnonzero(falls[asked] > 0)
    if sun.any() and len(lit):
        directions = towards[:, None] + (dice[2:, lit] - 0.5) * 0.03
        reach = np.full(len(lit), 200, np.float32)
        shares[-3, cells[lit]] = ~solids.blocked(points_asked[:, lit].T, directions.T, reach)
    gains = lamp_gains(lamps, surface.points, normals)
    shares[-2, cells] = _lamps_seen(lamps, gains[:, asked], solids, points_asked, dice[2], rng)
    traced_shares, keys = shares.reshape(-1, *traced), surface_keys(surface).reshape(size)
    if second is None:
        smooth = means(with_neighbours(with_neighbours(traced_shares, keys, 1), keys, 3))
        is_open, in_sun, by_lamps = smooth.reshape(3, -1)
        light = _ambient(scene, normals, is_open)
    else:
        met = surface.met.reshape(size)[::2, ::2]
        coarse = np.where(met, keys[::2, ::2], -1)
        every = refined(_calmed(traced_shares, coarse), coarse, keys).reshape(5, -1)
        light, in_sun, by_lamps = every[:3], every[3], every[4]
    if lamps:
        light += (lamp_hues(lamps) @ gains) * by_lamps
    if sun.any():
        light += sun[:, None] * (falls * in_sun)
    return np.asarray(light, dtype=np.float32)


def _calmed(shares: Floats32, keys: Keys) -> Floats32:
    """Smooth light of the surroundings, and shares of sun and lamps, (5, h, w).

    The sun's shadows are smoothed least: they are sharp. The light of the surroundings is smoothed
    further where nothing is near.

    Args:
        shares: (7, h, w): light, the share of rays that soon met something, those that reach the
            sun and a lamp, and weight.
        keys: (h, w), which surface each pixel shows.
    """
    close = with_neighbours(shares, keys, 1)
    *around, near, _, by_lamps = means(with_neighbours(close, keys, 2))
    in_sun = means(close[[-3, -1]])
    light = np.asarray(around, np.float32)
    *wide, weight = with_neighbours(
        with_neighbours(np.concatenate([light, np.ones_like(in_sun)]), keys, 2), keys, 4
    )
    calm = np.stack(wide) / weight
    light = calm + (light - calm) * np.minimum(near * 2, 1)
    return np.concatenate([light, in_sun, by_lamps[None]])


def _ambient(scene: Scene, normals: Floats32, is_open: Floats32) -> Floats32:
    rise = 0.5 + 0.5 * normals[2]
    rise = 0.55 + 0.45 * rise if scene.kind == "street" else 0.85 + 0.15 * rise
    return np.asarray(vector(scene.ambient)[:, None] * (rise * (0.25 + 0.75 * is_open**1.2)))


def _around(normals: Floats32, dice: Floats32) -> Floats32:
    """One direction a point, (3, N): the more often the closer to its normal."""
    angle = dice[0] * np.float32(2 * np.pi)
    radius = np.sqrt(dice[1])
    x, y, z = normals
    upright = (np.abs(z) < 0.9).astype(np.float32)
    first = np.stack([-y * upright, x * upright - z * (1 - upright), y * (1 - upright)])
    first /= np.maximum(np.sqrt(dot(first, first)), 1e-6)
    second = np.stack(
        [y * first[2] - z * first[1], z * first[0] - x * first[2], x * first[1] - y * first[0]]
    )
    directions = normals * np.sqrt(1 - dice[1])
    directions += first * (radius * np.cos(angle)) + second * (radius * np.sin(angle))
    return np.asarray(directions)


def _openness(
    solids: Triangles, points: Floats32, directions: Floats32, reach_m: float
) -> Floats32:
    """Share of the hemisphere that is open, one ray a point: 1 or 0, less if met far away."""
    met_m = solids.distances(points.T, directions.T)
    return np.asarray(np.clip(met_m / reach_m, 0, 1) ** 0.7, dtype=np.float32)


def _lamps_seen(
    lamps: list[Lamp],
    gains: Floats32,
    solids: Triangles,
    points: Floats32,
    dice: Floats32,
    rng: np.random.Generator,
) -> NDArray[np.bool_]:
    """Whether each point sees one lamp, drawn by the light that it would give."""
    count = points.shape[1]
    if not lamps:
        return np.ones(count, np.bool_)
    running = np.cumsum(gains, axis=0)
    chosen = (running < dice * running[-1]).sum(axis=0)
    chosen = np.minimum(chosen, len(lamps) - 1)
    centres = np.array([lamp.centre_m for lamp in lamps], np.float32)
    sizes = np.array([lamp.size_m for lamp in lamps], np.float32)
    spot = rng.random((count, 3), dtype=np.float32).T - 0.5
    target = centres.T[:, chosen] + sizes.T[:, chosen] * spot
    return ~solids.blocked(points.T, (target - points).T, np.full(count, 0.96, np.float32))
