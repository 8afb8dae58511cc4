"""The picture of a scene: textures, light, shadow, mirrors, haze.

One ray a pixel for the surface; from there one towards a lamp or the sun, one into the open for
the light from everywhere. Lamps have a size and each pixel aims at its own spot of them; a filter
that stays on one surface turns that noise into soft shadows.

Points, directions and colours are planes (3, N), one for each component: numpy is slow at axes as
short as three where they come last.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Size
from footprints_edge_models.scenes.assets.textures import SIDE_PX, TextureKey, TextureLibrary
from footprints_edge_models.scenes.layout.scene import Lamp, Scene
from footprints_edge_models.scenes.layout.skies import sky_colours
from footprints_edge_models.scenes.rendering.cameras import Camera
from footprints_edge_models.scenes.rendering.geometry import Geometry
from footprints_edge_models.scenes.rendering.raycast import Hits, Triangles
from footprints_edge_models.scenes.vectors import vector

Floats = NDArray[np.float32]

SUPERSAMPLING = 1.1
"""Colours are computed at this many pixels for each of the picture's, along each side."""
LEVELS = 6
LEAST_MIRRORED = 0.035
MOST_LAMPS = 5
"""Those that give a picture's surfaces the most light."""
_LINEAR = ((np.arange(256) / 255) ** 2.2).astype(np.float32)
_SIDES = np.array([SIDE_PX >> level for level in range(LEVELS)], np.float32)
_OFFSET_M = np.float32(2e-3)


class _Atlas:
    """All textures of a scene in one picture, each at LEVELS sizes, so that OpenCV samples them."""

    def __init__(self, keys: list[TextureKey], library: TextureLibrary) -> None:
        self.row = {key: index for index, key in enumerate(dict.fromkeys(keys))}
        side = SIDE_PX + 2
        width = 2 * SIDE_PX + 2 * LEVELS
        per_strip = 32000 // side
        strips = -(-len(self.row) // per_strip)
        self.per_strip, self.width = per_strip, width
        self.pixels = np.zeros((min(len(self.row), per_strip) * side, strips * width, 3), np.uint8)
        self.start = np.cumsum([0] + [(SIDE_PX >> level) + 2 for level in range(LEVELS - 1)])
        for key, index in self.row.items():
            texture = library.draw(key)
            top, left = index % per_strip * side, index // per_strip * width
            for level in range(LEVELS):
                tile = cv2.copyMakeBorder(texture, 1, 1, 1, 1, cv2.BORDER_WRAP)
                x = left + int(self.start[level])
                self.pixels[top : top + len(tile), x : x + tile.shape[1]] = tile
                texture = cv2.resize(texture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)

    def sample(self, row: NDArray[np.int32], uv: Floats, level: NDArray[np.int32]) -> Floats:
        """Linear colours (3, N) at ``uv`` (2, N), in repeats of the textures."""
        within = (uv - np.floor(uv)) * _SIDES[level] + np.float32(0.5)
        count = len(row)
        columns = 8192
        rows = -(-count // columns)
        grid_x, grid_y = np.zeros((2, rows * columns), np.float32)
        strip, place = np.divmod(row, self.per_strip)
        np.add(within[0], self.start[level] + strip * self.width, out=grid_x[:count])
        np.add(within[1], place * (SIDE_PX + 2), out=grid_y[:count])
        shape = (rows, columns)
        values = cv2.remap(
            self.pixels, grid_x.reshape(shape), grid_y.reshape(shape), cv2.INTER_LINEAR
        )
        return np.asarray(np.take(_LINEAR, values.reshape(-1, 3)[:count].T))


@dataclass(frozen=True)
class _Surface:
    """What N rays met, or not: points, normals and colours are (3, N)."""

    met: NDArray[np.bool_]
    points: Floats
    normals: Floats
    albedo: Floats
    material: NDArray[np.int32]
    part: NDArray[np.int32]
    distance_m: Floats


@dataclass(frozen=True)
class _Materials:
    row: NDArray[np.int32]
    tile_m: Floats
    tint: Floats
    gloss: Floats
    sharpness: Floats
    glow: Floats
    atlas: _Atlas = field(repr=False)


def render(
    scene: Scene,
    geometry: Geometry,
    solids: Triangles,
    camera: Camera,
    library: TextureLibrary,
    rng: np.random.Generator,
) -> Floats:
    """The light that falls on the camera: linear RGB, float32 (H, W, 3)."""
    size = (round(camera.size[0] * SUPERSAMPLING), round(camera.size[1] * SUPERSAMPLING))
    eye, rays = camera.rays(size)
    lengths: Floats = np.sqrt(_dot(rays.T, rays.T))
    origins, directions = eye.T, np.asarray(rays.T / lengths, dtype=np.float32)
    hits = solids.first_hits(origins.T, directions.T)
    met = np.flatnonzero(np.bincount(geometry.material[hits.triangle[hits.triangle >= 0]]))
    materials = _tables(geometry, library, met)
    pixel_m = np.float32(1 / (camera.intrinsics.focal_px * SUPERSAMPLING)) / lengths
    surface = _surface(geometry, materials, hits, origins, directions, pixel_m)
    light = _light(scene, solids, surface, size, rng)
    colours = surface.albedo * (light + materials.glow[surface.material])
    _mirror(scene, geometry, materials, solids, surface, directions, colours, size, library)
    if scene.haze_m < 1e5:
        share = np.exp(surface.distance_m / np.float32(-scene.haze_m))
        colours = colours * share + vector(scene.sky.horizon)[:, None] * 0.8 * (1 - share)
    sky = np.flatnonzero(~surface.met)
    if len(sky):
        colours[:, sky] = sky_colours(scene.sky, directions[:, sky].T, library).T
    picture = cv2.merge(list(colours.reshape(3, *size)))
    return np.asarray(cv2.resize(picture, camera.size[::-1], interpolation=cv2.INTER_AREA))


def _dot(first: Floats, second: Floats) -> Floats:
    """Of vectors (3, N)."""
    return np.asarray(first[0] * second[0] + first[1] * second[1] + first[2] * second[2])


def _tables(geometry: Geometry, library: TextureLibrary, met: NDArray[np.int64]) -> _Materials:
    """The materials as arrays; only textures of those in ``met`` are drawn.

    What shows in a mirror alone takes the texture of something else: it is hardly told apart.
    """
    atlas = _Atlas([geometry.materials[k].texture for k in met], library)
    return _Materials(
        np.array([atlas.row.get(m.texture, 0) for m in geometry.materials], np.int32),
        np.array([m.tile_m for m in geometry.materials], np.float32),
        np.array([m.tint for m in geometry.materials], np.float32).T,
        np.array([m.gloss for m in geometry.materials], np.float32),
        np.array([m.sharpness for m in geometry.materials], np.float32),
        np.array([m.glow for m in geometry.materials], np.float32),
        atlas,
    )


def _surface(
    geometry: Geometry,
    materials: _Materials,
    hits: Hits,
    origins: Floats,
    directions: Floats,
    pixel_m: Floats,
) -> _Surface:
    """Points, normals towards the eye and colours; ``pixel_m`` is a pixel's width at one metre."""
    met = hits.triangle >= 0
    triangle = np.where(met, hits.triangle, 0)
    distance = np.where(met, hits.distance, np.float32(1))
    u, v = hits.u, hits.v
    weights = (1 - u - v, u, v)
    normals = _blended(geometry.normals, triangle, weights)
    normals /= np.maximum(np.sqrt(_dot(normals, normals)), 1e-9)
    facing = _dot(normals, directions)
    normals *= np.where(facing > 0, np.float32(-1), np.float32(1))
    material = geometry.material[triangle]
    tile_m = materials.tile_m[material]
    uv = _blended(geometry.uv, triangle, weights) / tile_m
    spread = distance * pixel_m / np.sqrt(np.maximum(np.abs(facing), 0.02)) * SIDE_PX / tile_m
    level = np.clip(np.log2(np.maximum(spread, 1)), 0, LEVELS - 1).astype(np.int32)
    albedo = materials.atlas.sample(materials.row[material], uv, level)
    albedo *= np.take(materials.tint, material, axis=1)
    points = origins + directions * distance + normals * _OFFSET_M
    return _Surface(met, points, normals, albedo, material, geometry.part[triangle], distance)


def _blended(
    at_corners: Floats, triangle: NDArray[np.int32], weights: tuple[Floats, ...]
) -> Floats:
    """Of what triangles have at their corners, (T, 3, C), that within them, (C, N)."""
    planes = np.ascontiguousarray(at_corners.transpose(1, 2, 0))
    first, second, third = (
        np.take(plane, triangle, axis=1) * weight
        for plane, weight in zip(planes, weights, strict=True)
    )
    return np.asarray(first + second + third)


def _pattern(size: Size, asked: NDArray[np.int64], count: int, rng: np.random.Generator) -> Floats:
    """Numbers (count, M) in [0, 1) for some pixels: stratified over each 3 x 3 block of pixels."""
    order = rng.permuted(np.tile(np.arange(9), (count, 1)), axis=1)
    jitter = rng.random((size[0] * size[1], count), dtype=np.float32)
    row, column = np.divmod(asked, size[1])
    place = np.take(order, row % 3 * 3 + column % 3, axis=1)
    return np.asarray((place + jitter[asked].T) / 9, dtype=np.float32)


def _light(
    scene: Scene,
    solids: Triangles,
    surface: _Surface,
    size: Size,
    rng: np.random.Generator,
) -> Floats:
    """Light on every point, (3, N).

    Every second pixel, as on a chessboard, is asked what it sees; the others learn it from those.
    """
    rows, columns = np.ogrid[: size[0], : size[1]]
    asked = np.flatnonzero(((rows + columns) % 2 == 0).ravel() & surface.met)
    dice = _pattern(size, asked, 5, rng)
    normals = surface.normals
    points_asked, normals_asked = (np.take(v, asked, axis=1) for v in (surface.points, normals))
    shares = np.zeros((4, size[0] * size[1]), np.float32)
    shares[3, asked] = 1
    reach_m = 0.9 if scene.kind == "rooms" else 2.0
    shares[0, asked] = _openness(solids, points_asked, normals_asked, dice[:2], reach_m)
    sun = vector(scene.sky.sun)
    towards = scene.sky.towards_sun.astype(np.float32)
    falls = np.maximum(towards @ normals, 0)
    lit = np.flatnonzero(falls[asked] > 0)
    if sun.any() and len(lit):
        directions = towards[:, None] + (dice[2:, lit] - 0.5) * 0.03
        reach = np.full(len(lit), 200, np.float32)
        shares[1, asked[lit]] = ~solids.blocked(points_asked[:, lit].T, directions.T, reach)
    lamps = _strongest(scene.lamps, points_asked)
    gains = _gains(lamps, surface.points, normals)
    shares[2, asked] = _lamps_seen(lamps, gains[:, asked], solids, points_asked, dice[2], rng)
    quantised = np.round(normals * 2).astype(np.int32) + 2
    key = surface.part * 125 + quantised[0] * 25 + quantised[1] * 5 + quantised[2]
    is_open, in_sun, by_lamps = _smoothed(shares.reshape(4, *size), key.reshape(size))
    rise = 0.5 + 0.5 * normals[2]
    rise = 0.55 + 0.45 * rise if scene.kind == "street" else 0.85 + 0.15 * rise
    light = vector(scene.ambient)[:, None] * (rise * (0.25 + 0.75 * is_open**1.2))
    if lamps:
        hues = [np.array(lamp.power) / max(np.mean(lamp.power), 1e-6) for lamp in lamps]
        light += (np.array(hues, np.float32).T @ gains) * by_lamps
    if sun.any():
        light += sun[:, None] * (falls * in_sun)
    return np.asarray(light, dtype=np.float32)


def _openness(
    solids: Triangles, points: Floats, normals: Floats, dice: Floats, reach_m: float
) -> Floats:
    """Share of the hemisphere that is open, one ray a point: 1 or 0, less if met far away."""
    angle = dice[0] * np.float32(2 * np.pi)
    radius = np.sqrt(dice[1])
    x, y, z = normals
    upright = (np.abs(z) < 0.9).astype(np.float32)
    first = np.stack([-y * upright, x * upright - z * (1 - upright), y * (1 - upright)])
    first /= np.maximum(np.sqrt(_dot(first, first)), 1e-6)
    second = np.stack(
        [y * first[2] - z * first[1], z * first[0] - x * first[2], x * first[1] - y * first[0]]
    )
    directions = normals * np.sqrt(1 - dice[1])
    directions += first * (radius * np.cos(angle)) + second * (radius * np.sin(angle))
    met_m = solids.distances(points.T, directions.T)
    return np.asarray(np.clip(met_m / reach_m, 0, 1) ** 0.7, dtype=np.float32)


def _strongest(lamps: tuple[Lamp, ...], points: Floats) -> list[Lamp]:
    """The MOST_LAMPS that give these points the most light, shadows aside."""
    if not lamps or not points.size:
        return list(lamps[:MOST_LAMPS])
    centres = np.array([lamp.centre_m for lamp in lamps], np.float32)
    away = centres - points.T[:: max(1, points.shape[1] // 500), None]
    near = (1 / (np.einsum("pli,pli->pl", away, away) + 0.5)).mean(axis=0)
    worth = near * np.array([np.mean(lamp.power) for lamp in lamps])
    return [lamps[k] for k in np.argsort(-worth, kind="stable")[:MOST_LAMPS]]


def _gains(lamps: list[Lamp], points: Floats, normals: Floats) -> Floats:
    """Light of each lamp on each point without shadow, (L, N)."""
    if not lamps:
        return np.zeros((0, points.shape[1]), np.float32)
    centres = np.array([lamp.centre_m for lamp in lamps], np.float32)
    power = np.array([[np.mean(lamp.power)] for lamp in lamps], np.float32)
    square = _dot(points, points) - 2 * centres @ points
    square = np.maximum(square + (centres**2).sum(axis=1)[:, None], 1e-3)
    falls = centres @ normals - _dot(normals, points)
    return np.asarray(power * np.maximum(falls, 0) / ((square + 0.5) * np.sqrt(square)))


def _lamps_seen(
    lamps: list[Lamp],
    gains: Floats,
    solids: Triangles,
    points: Floats,
    dice: Floats,
    rng: np.random.Generator,
) -> NDArray[np.bool_]:
    """Whether each point sees one lamp, chosen the more often the more light it would give."""
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


def _smoothed(values: Floats, key: NDArray[np.int32]) -> Floats:
    """Means over about 9 pixels across that never leave a surface.

    Args:
        values: (C, H, W); the last channel is weight.
        key: (H, W), which surface each pixel shows.

    Returns:
        (C - 1, H * W).
    """
    for step in (1, 3):
        total = values.copy()
        for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
            y, x = dy * step, dx * step
            here = (slice(None, -y or None), slice(max(0, -x), -x if x > 0 else None))
            there = (slice(y, None), slice(max(0, x), x if x < 0 else None))
            same = (key[here] == key[there]).astype(np.float32)
            for old, new in zip(values, total, strict=True):
                new[here] += old[there] * same
                new[there] += old[here] * same
        values = total
    # slivers that nobody was asked on take what is around them
    lonely = values[-1] < 0.5
    if lonely.any():
        for plane in values:
            plane[lonely] = cv2.blur(plane, (9, 9))[lonely]
    return np.asarray(values[:-1] / np.maximum(values[-1], 1e-6)).reshape(len(values) - 1, -1)


def _mirror(
    scene: Scene,
    geometry: Geometry,
    materials: _Materials,
    solids: Triangles,
    surface: _Surface,
    directions: Floats,
    colours: Floats,
    size: Size,
    library: TextureLibrary,
) -> None:
    """Adds what glossy surfaces mirror, blurred as their materials say."""
    base = materials.gloss[surface.material] * surface.met
    facing = -_dot(surface.normals, directions)
    grazing = (1 - np.clip(facing, 0, 1)) ** 5
    share = base + (1 - base) * np.minimum(base * 5, 0.8) * grazing
    shiny = np.flatnonzero(share > LEAST_MIRRORED)
    if not len(shiny):
        return
    share = share[shiny]
    points, normals, incoming = (
        np.take(v, shiny, axis=1) for v in (surface.points, surface.normals, directions)
    )
    outgoing = incoming + 2 * facing[shiny] * normals
    hits = solids.first_hits(points.T, outgoing.T)
    pixel_m = np.full(len(shiny), 4e-3, np.float32)
    behind = _surface(geometry, materials, hits, points, outgoing, pixel_m)
    light = vector(scene.ambient)[:, None] * 0.8
    if scene.kind == "rooms":
        light = light + 0.35
    else:
        falls = np.maximum(scene.sky.towards_sun.astype(np.float32) @ behind.normals, 0)
        light = light + falls * vector(scene.sky.sun)[:, None] * 0.7
    mirrored = behind.albedo * (light + materials.glow[behind.material])
    sky = np.flatnonzero(~behind.met)
    mirrored[:, sky] = sky_colours(scene.sky, outgoing[:, sky].T, library).T
    mirrored = np.minimum(mirrored, 4)
    sharp = materials.sharpness[surface.material[shiny]]
    weight = np.maximum(_softened(np.ones(len(shiny), np.float32), shiny, size), 1e-3)
    for colour, clear in zip(colours, mirrored, strict=True):
        blurred = _softened(clear, shiny, size) / weight
        mixed = blurred + (clear - blurred) * sharp
        colour[shiny] += (mixed - colour[shiny]) * share


def _softened(values: Floats, pixels: NDArray[np.int64], size: Size) -> Floats:
    """Values (M,) at some pixels, blurred: floors draw mirrored things out in height."""
    plane = np.zeros(size[0] * size[1], np.float32)
    plane[pixels] = values
    soft = cv2.blur(cv2.blur(plane.reshape(size), (5, 13)), (5, 9))
    return np.take(soft, pixels)
