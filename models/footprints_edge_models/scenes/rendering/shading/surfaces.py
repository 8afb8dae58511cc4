"""What rays meet: points, normals and colours."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.rendering.geometry import Geometry
from footprints_edge_models.scenes.rendering.raycast import Floats32, Hits
from footprints_edge_models.scenes.rendering.shading.atlas import LEVELS, TextureAtlas
from footprints_edge_models.scenes.vectors import dot

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
) -> Surface:
    """Points, normals towards the eye and colours; ``pixel_m`` is a pixel's width at one metre."""
    met = hits.triangle >= 0
    triangle = np.where(met, hits.triangle, 0)
    distance = np.where(met, hits.distance, np.float32(1))
    u, v = hits.u, hits.v
    weights = (1 - u - v, u, v)
    normals = _blended(geometry.normal_planes, triangle, weights)
    normals /= np.maximum(np.sqrt(dot(normals, normals)), 1e-9)
    facing = dot(normals, directions)
    normals *= np.where(facing > 0, np.float32(-1), np.float32(1))
    material = geometry.material[triangle]
    tile_m = materials.tile_m[material]
    row = materials.row[material]
    side_px = materials.atlas.side[row].astype(np.float32)
    uv = _blended(geometry.uv_planes, triangle, weights) / tile_m
    spread = distance * pixel_m / np.sqrt(np.maximum(np.abs(facing), 0.02)) * side_px / tile_m
    level = np.clip(np.log2(np.maximum(spread, 1)), 0, LEVELS - 1).astype(np.int32)
    albedo = materials.atlas.sample(row, uv, level)
    albedo *= np.take(materials.tint, material, axis=1)
    points = origins + directions * distance + normals * _OFFSET_M
    return Surface(met, points, normals, albedo, material, geometry.part[triangle], distance)


def _blended(
    planes: Floats32, triangle: NDArray[np.int32], weights: tuple[Floats32, ...]
) -> Floats32:
    """Interpolates values at the corners of triangles, (3, C, T), to points in them, (C, N)."""
    first, second, third = (
        np.take(plane, triangle, axis=1) * weight
        for plane, weight in zip(planes, weights, strict=True)
    )
    return np.asarray(first + second + third)
