"""Light on surfaces: lamps, sun, and the light from everywhere, with soft shadows."""

import cv2
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
from footprints_edge_models.scenes.rendering.shading.surfaces import Surface
from footprints_edge_models.scenes.vectors import dot, vector


def _pattern(
    size: Size, asked: NDArray[np.int64], count: int, rng: np.random.Generator
) -> Floats32:
    """Random numbers (count, M) in [0, 1) for some pixels, stratified over each 3 x 3 block."""
    order = rng.permuted(np.tile(np.arange(9), (count, 1)), axis=1)
    jitter = rng.random((size[0] * size[1], count), dtype=np.float32)
    row, column = np.divmod(asked, size[1])
    place = np.take(order, row % 3 * 3 + column % 3, axis=1)
    return np.asarray((place + jitter[asked].T) / 9, dtype=np.float32)


def light_on(
    scene: Scene,
    solids: Triangles,
    surface: Surface,
    size: Size,
    rng: np.random.Generator,
    second: SecondLight | None = None,
) -> Floats32:
    """Light on every point, (3, N).

    Rays are traced for every second pixel, as on a chessboard; a filter fills the others.

    Args:
        scene: the scene.
        solids: ray tracer of all triangles.
        surface: the points.
        size: (H, W) of the picture that they make.
        rng: draws where rays go.
        second: the light of the sky and of other surfaces; without it the scene's ambient light,
            less where little of the surroundings is open.
    """
    rows, columns = np.ogrid[: size[0], : size[1]]
    asked = np.flatnonzero(((rows + columns) % 2 == 0).ravel() & surface.met)
    dice = _pattern(size, asked, 5, rng)
    normals = surface.normals
    points_asked, normals_asked = (np.take(v, asked, axis=1) for v in (surface.points, normals))
    lamps = strongest_lamps(scene.lamps, points_asked)
    away = _around(normals_asked, dice[:2])
    if second is None:
        reach_m = 0.9 if scene.kind == "rooms" else 2.0
        around = _openness(solids, points_asked, away, reach_m)[None]
    else:
        around = second.along(points_asked, away, lamps)
    shares = np.zeros((len(around) + 3, size[0] * size[1]), np.float32)
    shares[-1, asked] = 1
    shares[:-3, asked] = around
    sun = vector(scene.sky.sun)
    towards = scene.sky.towards_sun.astype(np.float32)
    falls = np.maximum(towards @ normals, 0)
    lit = np.flatnonzero(falls[asked] > 0)
    if sun.any() and len(lit):
        directions = towards[:, None] + (dice[2:, lit] - 0.5) * 0.03
        reach = np.full(len(lit), 200, np.float32)
        shares[-3, asked[lit]] = ~solids.blocked(points_asked[:, lit].T, directions.T, reach)
    gains = lamp_gains(lamps, surface.points, normals)
    shares[-2, asked] = _lamps_seen(lamps, gains[:, asked], solids, points_asked, dice[2], rng)
    quantised = np.round(normals * 2).astype(np.int32) + 2
    key = surface.part * 125 + quantised[0] * 25 + quantised[1] * 5 + quantised[2]
    *arriving, in_sun, by_lamps = _smoothed(shares.reshape(-1, *size), key.reshape(size))
    if second is None:
        light = _ambient(scene, normals, arriving[0])
    else:
        light = _calmed(np.array(arriving, np.float32).reshape(-1, *size), key.reshape(size))
    if lamps:
        light += (lamp_hues(lamps) @ gains) * by_lamps
    if sun.any():
        light += sun[:, None] * (falls * in_sun)
    return np.asarray(light, dtype=np.float32)


def _calmed(around: Floats32, key: NDArray[np.int32]) -> Floats32:
    """Light of the surroundings (3, H * W), smoothed further where nothing is near.

    Args:
        around: (4, H, W): light, and the share of rays that soon met something.
        key: (H, W), which surface each pixel shows.
    """
    weighted = np.concatenate([around[:3], np.ones_like(around[:1])])
    *wide, weight = _with_neighbours(_with_neighbours(weighted, key, 4), key, 9)
    near = np.minimum(around[3] * 2, 1)
    calm = np.stack(wide) / weight
    return np.asarray(calm + (around[:3] - calm) * near).reshape(3, -1)


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


def _with_neighbours(values: Floats32, key: NDArray[np.int32], step: int) -> Floats32:
    """Sums (C, H, W) with those of the eight pixels ``step`` away that are on the same surface."""
    total = values.copy()
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        y, x = dy * step, dx * step
        here = (slice(None, -y or None), slice(max(0, -x), -x if x > 0 else None))
        there = (slice(y, None), slice(max(0, x), x if x < 0 else None))
        same = (key[here] == key[there]).astype(np.float32)
        for old, new in zip(values, total, strict=True):
            new[here] += old[there] * same
            new[there] += old[here] * same
    return total


def _smoothed(values: Floats32, key: NDArray[np.int32]) -> Floats32:
    """Means over about 9 pixels across that stay on one surface.

    Args:
        values: (C, H, W); the last channel is weight.
        key: (H, W), which surface each pixel shows.

    Returns:
        (C - 1, H * W).
    """
    for step in (1, 3):
        values = _with_neighbours(values, key, step)
    # slivers without a traced pixel take the values around them
    lonely = values[-1] < 0.5
    if lonely.any():
        for plane in values:
            plane[lonely] = cv2.blur(plane, (9, 9))[lonely]
    return np.asarray(values[:-1] / np.maximum(values[-1], 1e-6)).reshape(len(values) - 1, -1)
