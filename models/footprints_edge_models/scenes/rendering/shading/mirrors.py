"""What glossy surfaces mirror."""

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Size
from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.layout.scene import Scene
from footprints_edge_models.scenes.layout.skies import sky_colours
from footprints_edge_models.scenes.rendering.geometry import Geometry
from footprints_edge_models.scenes.rendering.raycast import Floats32, Triangles
from footprints_edge_models.scenes.rendering.shading.surfaces import (
    MaterialTable,
    Surface,
    surface_at,
)
from footprints_edge_models.scenes.vectors import dot, vector

LEAST_MIRRORED = 0.035


def add_mirrored(
    scene: Scene,
    geometry: Geometry,
    materials: MaterialTable,
    solids: Triangles,
    surface: Surface,
    directions: Floats32,
    colours: Floats32,
    size: Size,
    library: TextureLibrary,
) -> None:
    """Adds what glossy surfaces mirror, blurred as their materials say."""
    base = materials.gloss[surface.material] * surface.met
    facing = -dot(surface.normals, directions)
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
    behind = surface_at(geometry, materials, hits, points, outgoing, pixel_m)
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


def _softened(values: Floats32, pixels: NDArray[np.int64], size: Size) -> Floats32:
    """Values (M,) at some pixels, blurred: floors draw mirrored things out in height."""
    plane = np.zeros(size[0] * size[1], np.float32)
    plane[pixels] = values
    soft = cv2.blur(cv2.blur(plane.reshape(size), (5, 13)), (5, 9))
    return np.take(soft, pixels)
