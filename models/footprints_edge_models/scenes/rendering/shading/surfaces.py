"""What rays meet: points, normals and colours."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Size
from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.rendering.geometry import Geometry
from footprints_edge_models.scenes.rendering.raycast import Floats32, Hits
from footprints_edge_models.scenes.rendering.shading.atlas import LEVELS, TextureAtlas
from footprints_edge_models.scenes.vectors import dot

_ROUND = 1.5
"""Patches that are longer than wide by less than this factor are sampled once."""
_BIAS = -0.4
"""Levels by which textures are softer than a pixel; negative, as several rays share a pixel."""
_FURTHEST = 2.0
"""Neighbours further apart than this, in repeats, lie on different sides of a seam."""
_OFFSET_M = np.float32(2e-3)


@dataclass(frozen=True)
class Surface:
    """What N rays met, or not: points, normals and colours are (3, N)."""

    met: NDArray[np.bool_]
    points: Floats32
    normals: Floats32
    albedo: Floats32
    material: NDArray[np.int32]
    part: NDArray[np.int32]
    distance_m: Floats32


@dataclass(frozen=True)
class Grid:
    """Rays that make a picture: from its neighbours a pixel knows how long its patch is.

    Attributes:
        size: (H, W) of the picture.
        taps: most samples along the longer side of a patch.
    """

    size: Size
    taps: int

    def sample(
        self,
        atlas: TextureAtlas,
        row: NDArray[np.int32],
        uv: Floats32,
        part: NDArray[np.int32],
        round_uv: Floats32,
    ) -> Floats32:
        """Linear colours (3, N) of textures, averaged over each pixel's patch.

        Args:
            atlas: the textures.
            row: which of them, (N,).
            uv: where, in repeats, (2, N).
            part: pixels of one part are neighbours on a surface, (N,).
            round_uv: sides of patches in repeats, where there is no neighbour, (N,).
        """
        along_x, along_y = (self._steps(uv, part, axis) for axis in (1, 0))
        long_x, long_y = (np.hypot(step[0], step[1]) for step in (along_x, along_y))
        known = (long_x > 0) & (long_y > 0) & (np.maximum(long_x, long_y) < _FURTHEST)
        longer = np.where(known, np.maximum(long_x, long_y), round_uv)
        shorter = np.where(known, np.minimum(long_x, long_y), round_uv)
        ratio = np.clip(longer / np.maximum(shorter, 1e-9), 1, self.taps)
        side = np.take(atlas.side, row)
        exact = np.log2(np.maximum(longer / ratio * side, 1e-3)) + np.float32(_BIAS)
        level = np.clip(np.rint(exact), 0, LEVELS - 1).astype(np.int32)
        colours = atlas.sample(row, uv, level)
        stretched = np.flatnonzero(known & (ratio > _ROUND))
        if len(stretched):
            way = np.where(long_x > long_y, along_x, along_y)[:, stretched]
            total = np.zeros((3, len(stretched)), np.float32)
            start, rows = np.take(uv, stretched, axis=1), row[stretched]
            for tap in range(self.taps):
                share = np.float32((tap + 0.5) / self.taps - 0.5)
                total += atlas.sample(rows, start + way * share, level[stretched])
            colours[:, stretched] = total / self.taps
        return colours

    def _steps(self, uv: Floats32, part: NDArray[np.int32], axis: int) -> Floats32:
        """How far a texture goes on to the next pixel, or came from the last; 0 if unknown."""
        plane, parts = uv.reshape(2, *self.size), part.reshape(self.size)
        step = np.diff(plane, axis=axis + 1) * (np.diff(parts, axis=axis) == 0)
        steps = np.zeros_like(plane)
        first, last = [slice(None)] * 3, [slice(None)] * 3
        first[axis + 1], last[axis + 1] = slice(None, -1), slice(1, None)
        steps[tuple(first)] = step
        nothing = steps[tuple(last)] == 0
        steps[tuple(last)] += step * nothing
        return steps.reshape(2, -1)


@dataclass(frozen=True)
class MaterialTable:
    """The M materials of a scene as arrays: ``tint`` and ``mean`` are (3, M), the others (M,).

    ``row`` is the place of a material's texture in the atlas, ``mean`` its mean colour.
    """

    row: NDArray[np.int32]
    tile_m: Floats32
    tint: Floats32
    mean: Floats32
    gloss: Floats32
    sharpness: Floats32
    glow: Floats32
    atlas: TextureAtlas = field(repr=False)


def material_table(
    geometry: Geometry, library: TextureLibrary, met: NDArray[np.int64]
) -> MaterialTable:
    """The materials as arrays; only textures of those in ``met`` are drawn.

    A material that shows in mirrors only takes the texture of another one: nobody sees the
    difference.
    """
    atlas = TextureAtlas([geometry.materials[k].texture for k in met], library)
    row = np.array([atlas.row.get(m.texture, 0) for m in geometry.materials], np.int32)
    tint = np.array([m.tint for m in geometry.materials], np.float32).T
    return MaterialTable(
        row,
        np.array([m.tile_m for m in geometry.materials], np.float32),
        tint,
        atlas.mean[:, row] * tint,
        np.array([m.gloss for m in geometry.materials], np.float32),
        np.array([m.sharpness for m in geometry.materials], np.float32),
        np.array([m.glow for m in geometry.materials], np.float32),
        atlas,
    )


def surface_at(
    geometry: Geometry,
    materials: MaterialTable,
    hits: Hits,
    origins: Floats32,
    directions: Floats32,
    pixel_m: Floats32,
    grid: "Grid | None" = None,
) -> Surface:
    """Points, normals towards the eye and colours.

    Args:
        geometry: the triangles.
        materials: what they are made of.
        hits: what the rays met.
        origins: where they started, (3, N).
        directions: unit, (3, N).
        pixel_m: a pixel's width at one metre, (N,).
        grid: the picture that the rays make; with it, textures are filtered by what lies between
            neighbouring pixels, else as if a pixel's patch on the surface were round.
    """
    met = hits.triangle >= 0
    triangle = np.where(met, hits.triangle, 0)
    distance = np.where(met, hits.distance, np.float32(1))
    u, v = hits.u, hits.v
    weights = (1 - u - v, u, v)
    normals = _blended(geometry.normals, triangle, weights)
    normals /= np.maximum(np.sqrt(dot(normals, normals)), 1e-9)
    facing = dot(normals, directions)
    normals *= np.where(facing > 0, np.float32(-1), np.float32(1))
    material = geometry.material[triangle]
    tile_m = materials.tile_m[material]
    row = materials.row[material]
    side_px = materials.atlas.side[row].astype(np.float32)
    uv = _blended(geometry.uv, triangle, weights) / tile_m
    spread = distance * pixel_m / np.sqrt(np.maximum(np.abs(facing), 0.02)) * side_px / tile_m
    if grid is None:
        level = np.clip(np.log2(np.maximum(spread, 1)), 0, LEVELS - 1).astype(np.int32)
        albedo = materials.atlas.sample(row, uv, level)
    else:
        part = np.where(met, geometry.part[triangle], -1)
        albedo = grid.sample(materials.atlas, row, uv, part, spread / side_px)
    albedo *= np.take(materials.tint, material, axis=1)
    points = origins + directions * distance + normals * _OFFSET_M
    return Surface(met, points, normals, albedo, material, geometry.part[triangle], distance)


def _blended(
    at_corners: Floats32, triangle: NDArray[np.int32], weights: tuple[Floats32, ...]
) -> Floats32:
    """Interpolates values at the corners of triangles, (T, 3, C), to points in them, (C, N)."""
    planes = np.ascontiguousarray(at_corners.transpose(1, 2, 0))
    first, second, third = (
        np.take(plane, triangle, axis=1) * weight
        for plane, weight in zip(planes, weights, strict=True)
    )
    return np.asarray(first + second + third)
