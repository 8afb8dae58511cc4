"""The picture of a scene: textures, light, shadow, mirrors, haze.

One ray a pixel for the surface; from there one towards a lamp or the sun, one into the open for
the light from everywhere. Lamps have a size and each pixel aims at its own spot of them; a filter
that stays on one surface turns that noise into soft shadows.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.arrays import Size

from .cameras import Camera
from .geometry import Geometry
from .raycast import Hits, Triangles
from .scene import Lamp, Scene
from .skies import sky_colours
from .textures import SIDE_PX, TextureKey, TextureLibrary
from .vectors import vector

Floats = NDArray[np.float32]

SUPERSAMPLING = 1.1
"""Colours are computed at this many pixels for each of the picture's, along each side."""
LEVELS = 6
LEAST_MIRRORED = 0.035
MOST_LAMPS = 5
"""Those that give a picture's surfaces the most light."""
_LINEAR = ((np.arange(256) / 255) ** 2.2).astype(np.float32)
_OFFSET_M = 2e-3


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
        """Linear colours (N, 3) at ``uv``, in repeats of the textures."""
        side = (SIDE_PX >> level).astype(np.float32)
        x = uv[:, 0] % 1 * side + 0.5 + self.start[level] + row // self.per_strip * self.width
        y = uv[:, 1] % 1 * side + 0.5 + row % self.per_strip * (SIDE_PX + 2)
        count = len(row)
        columns = 8192
        rows = -(-count // columns)
        grid_x, grid_y = (np.zeros(rows * columns, np.float32) for _ in range(2))
        grid_x[:count], grid_y[:count] = x, y
        shape = (rows, columns)
        values = cv2.remap(
            self.pixels, grid_x.reshape(shape), grid_y.reshape(shape), cv2.INTER_LINEAR
        )
        return np.asarray(_LINEAR[values.reshape(-1, 3)[:count]])


@dataclass(frozen=True)
class _Surface:
    """What rays met: N of them, met or not."""

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
    origins, directions = camera.rays(size)
    lengths = np.sqrt(np.einsum("ij,ij->i", directions, directions))[:, None]
    directions = directions / lengths
    hits = solids.first_hits(origins, directions)
    met = np.unique(geometry.material[hits.triangle[hits.triangle >= 0]])
    materials = _tables(geometry, library, met)
    pixel_m = 1 / (camera.intrinsics.focal_px * SUPERSAMPLING * lengths[:, 0])
    surface = _surface(geometry, materials, hits, origins, directions, pixel_m)
    light = _light(scene, solids, surface, size, rng)
    colours = surface.albedo * light
    colours += surface.albedo * materials.glow[surface.material][:, None]
    _mirror(scene, geometry, materials, solids, surface, directions, colours, size, library)
    sky = ~surface.met
    if scene.haze_m < 1e5:
        share = np.exp(-surface.distance_m / scene.haze_m)[:, None]
        colours = colours * share + vector(scene.sky.horizon) * 0.8 * (1 - share)
    if sky.any():
        colours[sky] = sky_colours(scene.sky, directions[sky], library)
    picture = colours.reshape(*size, 3)
    return np.asarray(cv2.resize(picture, camera.size[::-1], interpolation=cv2.INTER_AREA))


def _tables(geometry: Geometry, library: TextureLibrary, met: NDArray[np.int32]) -> _Materials:
    """The materials as arrays; only textures of those in ``met`` are drawn.

    What shows in a mirror alone takes the texture of something else: it is hardly told apart.
    """
    atlas = _Atlas([geometry.materials[k].texture for k in met], library)
    return _Materials(
        np.array([atlas.row.get(m.texture, 0) for m in geometry.materials], np.int32),
        np.array([m.tile_m for m in geometry.materials], np.float32),
        np.array([m.tint for m in geometry.materials], np.float32),
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
    distance = np.where(met, hits.distance, 1).astype(np.float32)
    u, v = hits.u[:, None], hits.v[:, None]
    w = 1 - u - v
    at = geometry.normals[triangle]
    normals = w * at[:, 0] + u * at[:, 1] + v * at[:, 2]
    normals /= np.maximum(np.sqrt(np.einsum("ij,ij->i", normals, normals))[:, None], 1e-9)
    facing = np.einsum("ij,ij->i", normals, directions)
    normals *= np.where(facing > 0, -1, 1).astype(np.float32)[:, None]
    at_uv = geometry.uv[triangle]
    material = geometry.material[triangle]
    tile_m = materials.tile_m[material]
    uv = (w * at_uv[:, 0] + u * at_uv[:, 1] + v * at_uv[:, 2]) / tile_m[:, None]
    spread = distance * pixel_m / np.sqrt(np.maximum(np.abs(facing), 0.02)) * SIDE_PX / tile_m
    level = np.clip(np.log2(np.maximum(spread, 1)), 0, LEVELS - 1).astype(np.int32)
    albedo = materials.atlas.sample(materials.row[material], uv, level) * materials.tint[material]
    points = origins + directions * distance[:, None] + normals * _OFFSET_M
    return _Surface(met, points, normals, albedo, material, geometry.part[triangle], distance)


def _pattern(size: Size, count: int, rng: np.random.Generator) -> Floats:
    """Numbers (H * W, count) in [0, 1): stratified over each 3 x 3 block of pixels."""
    order = rng.permuted(np.tile(np.arange(9), (count, 1)), axis=1).reshape(count, 3, 3)
    tiles = (-(-size[0] // 3), -(-size[1] // 3))
    grid = np.tile(order, (1, *tiles))[:, : size[0], : size[1]].reshape(count, -1).T
    jitter = rng.random(grid.shape, dtype=np.float32)
    return np.asarray((grid + jitter) / 9, dtype=np.float32)


def _light(
    scene: Scene,
    solids: Triangles,
    surface: _Surface,
    size: Size,
    rng: np.random.Generator,
) -> Floats:
    """Light on every point, (N, 3).

    Every second pixel, as on a chessboard, is asked what it sees; the others learn it from those.
    """
    rows, columns = np.indices(size)
    asked = np.flatnonzero(((rows + columns) % 2 == 0).ravel() & surface.met)
    dice = _pattern(size, 5, rng)[asked]
    points, normals = surface.points[asked], surface.normals[asked]
    shares = np.zeros((len(surface.points), 4), np.float32)
    shares[asked, 3] = 1
    reach_m = 0.9 if scene.kind == "rooms" else 2.0
    shares[asked, 0] = _openness(solids, points, normals, dice[:, :2], reach_m)
    sun = vector(scene.sky.sun)
    towards = scene.sky.towards_sun.astype(np.float32)
    falls = surface.normals @ towards
    lit = np.flatnonzero(falls[asked] > 0)
    if sun.any() and len(lit):
        directions = towards + (dice[lit, 2:] - 0.5) * 0.03
        reach = np.full(len(directions), 200, np.float32)
        shares[asked[lit], 1] = ~solids.blocked(points[lit], directions, reach)
    lamps = _strongest(scene.lamps, points)
    gains = _gains(lamps, surface.points, surface.normals)
    shares[asked, 2] = _lamps_seen(lamps, gains[asked], solids, points, dice[:, 2], rng)
    quantised = np.round(surface.normals * 2).astype(np.int32) + 2
    key = surface.part * 125 + quantised[:, 0] * 25 + quantised[:, 1] * 5 + quantised[:, 2]
    shares = _smoothed(shares.reshape(*size, 4), key.reshape(size)).reshape(-1, 4)
    normals = surface.normals
    rise = 0.5 + 0.5 * normals[:, 2:]
    ambient = vector(scene.ambient)
    everywhere = (
        ambient * (0.55 + 0.45 * rise) if scene.kind == "street" else ambient * (0.85 + 0.15 * rise)
    )
    light = everywhere * (0.25 + 0.75 * shares[:, :1] ** 1.2)
    hues = np.array([np.array(lamp.power) / max(np.mean(lamp.power), 1e-6) for lamp in lamps])
    light += (gains @ hues.reshape(-1, 3).astype(np.float32)) * shares[:, 2:3]
    light += sun * (np.maximum(falls, 0) * shares[:, 1])[:, None]
    return np.asarray(light, dtype=np.float32)


def _openness(
    solids: Triangles, points: Floats, normals: Floats, dice: Floats, reach_m: float
) -> Floats:
    """Share of the hemisphere that is open, one ray a point: 1 or 0, less if met far away."""
    angle = dice[:, 0] * np.float32(2 * np.pi)
    radius = np.sqrt(dice[:, 1])
    height = np.sqrt(1 - dice[:, 1])
    ball = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)
    directions = normals * ball[:, 2:]
    helper = np.where(np.abs(normals[:, 2:]) < 0.9, vector([0, 0, 1]), vector([1, 0, 0]))
    first = np.cross(helper, normals)
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-6)
    directions += first * ball[:, :1] + np.cross(normals, first) * ball[:, 1:2]
    met_m = solids.distances(points, directions)
    return np.asarray(np.clip(met_m / reach_m, 0, 1) ** 0.7, dtype=np.float32)


def _strongest(lamps: tuple[Lamp, ...], points: Floats) -> list[Lamp]:
    """The MOST_LAMPS that give these points the most light, shadows aside."""
    if not lamps or not len(points):
        return list(lamps[:MOST_LAMPS])
    centres = np.array([lamp.centre_m for lamp in lamps], np.float32)
    away = centres - points[:: max(1, len(points) // 500), None]
    near = (1 / (np.einsum("pli,pli->pl", away, away) + 0.5)).mean(axis=0)
    worth = near * np.array([np.mean(lamp.power) for lamp in lamps])
    return [lamps[k] for k in np.argsort(-worth, kind="stable")[:MOST_LAMPS]]


def _gains(lamps: list[Lamp], points: Floats, normals: Floats) -> Floats:
    """Light of each lamp on each point without shadow, (N, L)."""
    if not lamps:
        return np.zeros((len(points), 0), np.float32)
    centres = np.array([lamp.centre_m for lamp in lamps], np.float32)
    power = np.array([np.mean(lamp.power) for lamp in lamps], np.float32)
    square = np.einsum("ij,ij->i", points, points)[:, None] - 2 * points @ centres.T
    square = np.maximum(square + (centres**2).sum(axis=1), 1e-3)
    falls = normals @ centres.T - np.einsum("ij,ij->i", normals, points)[:, None]
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
    if not lamps:
        return np.ones(len(points), np.bool_)
    running = np.cumsum(gains, axis=1)
    chosen = (running < dice[:, None] * running[:, -1:]).sum(axis=1)
    chosen = np.minimum(chosen, len(lamps) - 1)
    centres = np.array([lamp.centre_m for lamp in lamps], np.float32)
    sizes = np.array([lamp.size_m for lamp in lamps], np.float32)
    target = centres[chosen] + sizes[chosen] * (
        rng.random((len(points), 3), dtype=np.float32) - 0.5
    )
    return ~solids.blocked(points, target - points, np.full(len(points), 0.96, np.float32))


def _smoothed(values: Floats, key: NDArray[np.int32]) -> Floats:
    """Means over about 9 pixels across that never leave a surface; the last channel is weight."""
    for step in (1, 3):
        total = values.copy()
        for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
            y, x = dy * step, dx * step
            here = (slice(None, -y or None), slice(max(0, -x), -x if x > 0 else None))
            there = (slice(y, None), slice(max(0, x), x if x < 0 else None))
            same = (key[here] == key[there]).astype(np.float32)[..., None]
            total[here] += values[there] * same
            total[there] += values[here] * same
        values = total
    # slivers that nobody was asked on take what is around them
    around = cv2.blur(values, (9, 9))
    lonely = values[..., 3] < 0.5
    values[lonely] = around[lonely]
    return np.asarray(values / np.maximum(values[..., 3:], 1e-6))


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
    base = np.where(surface.met, materials.gloss[surface.material], 0)
    facing = -np.einsum("ij,ij->i", surface.normals, directions)
    grazing = (1 - np.clip(facing, 0, 1)) ** 5
    share = base + (1 - base) * np.minimum(base * 5, 0.8) * grazing
    shiny = np.flatnonzero(share > LEAST_MIRRORED)
    if not len(shiny):
        return
    normals, incoming, facing = surface.normals[shiny], directions[shiny], facing[shiny]
    outgoing = incoming + 2 * facing[:, None] * normals
    hits = solids.first_hits(surface.points[shiny], outgoing)
    behind = _surface(
        geometry,
        materials,
        hits,
        surface.points[shiny],
        outgoing,
        np.full(len(shiny), 4e-3, np.float32),
    )
    light = vector(scene.ambient) * 0.8
    if scene.kind == "rooms":
        light = light + 0.35
    else:
        falls = np.maximum(behind.normals @ scene.sky.towards_sun.astype(np.float32), 0)
        light = light + falls[:, None] * vector(scene.sky.sun) * 0.7
    mirrored = behind.albedo * (light + materials.glow[behind.material][:, None])
    mirrored[~behind.met] = sky_colours(scene.sky, outgoing[~behind.met], library)
    picture = np.zeros((size[0] * size[1], 4), np.float32)
    picture[shiny, :3], picture[shiny, 3] = np.minimum(mirrored, 4), 1
    grid = picture.reshape(*size, 4)
    soft = cv2.blur(cv2.blur(grid, (5, 13)), (5, 9))  # floors draw mirrored things out in height
    blurred = soft.reshape(-1, 4)[shiny]
    blurred = blurred[:, :3] / np.maximum(blurred[:, 3:], 1e-3)
    sharp = materials.sharpness[surface.material[shiny]][:, None]
    mixed = blurred + (np.minimum(mirrored, 4) - blurred) * sharp
    colours[shiny] += (mixed - colours[shiny]) * share[shiny, None]
