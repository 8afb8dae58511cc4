"""The picture of a scene: textures, light, shadow, mirrors, haze.

One ray a pixel for the surface; from there one towards a lamp or the sun, one into the open for
the light from everywhere. Lamps have a size and each pixel aims at its own spot of them; a filter
that stays on one surface turns that noise into soft shadows.

Points, directions and colours are planes (3, N), one for each component: numpy is slow at axes as
short as three where they come last.
"""

import cv2
import numpy as np

from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.layout.scene import Scene
from footprints_edge_models.scenes.layout.skies import sky_colours
from footprints_edge_models.scenes.rendering.cameras import Camera
from footprints_edge_models.scenes.rendering.geometry import Geometry
from footprints_edge_models.scenes.rendering.look import Look
from footprints_edge_models.scenes.rendering.raycast import Floats32, Triangles
from footprints_edge_models.scenes.rendering.shading.bounced import SecondLight, sky_table
from footprints_edge_models.scenes.rendering.shading.light import light_on
from footprints_edge_models.scenes.rendering.shading.mirrors import add_mirrored
from footprints_edge_models.scenes.rendering.shading.surfaces import material_table, surface_at
from footprints_edge_models.scenes.vectors import dot, vector


def render(
    scene: Scene,
    geometry: Geometry,
    solids: Triangles,
    camera: Camera,
    library: TextureLibrary,
    look: Look,
    rng: np.random.Generator,
) -> Floats32:
    """The light that falls on the camera: linear RGB, float32 (H, W, 3)."""
    size = (round(camera.size[0] * look.supersampling), round(camera.size[1] * look.supersampling))
    eye, rays = camera.rays(size)
    lengths: Floats32 = np.sqrt(dot(rays.T, rays.T))
    origins, directions = eye.T, np.asarray(rays.T / lengths, dtype=np.float32)
    hits = solids.first_hits(origins.T, directions.T)
    met = np.flatnonzero(np.bincount(geometry.material[hits.triangle[hits.triangle >= 0]]))
    materials = material_table(geometry, library, met)
    pixel_m = np.float32(1 / (camera.intrinsics.focal_px * look.supersampling)) / lengths
    surface = surface_at(geometry, materials, hits, origins, directions, pixel_m)
    second = None
    if look.bounced:
        second = SecondLight(scene, geometry, materials, solids, sky_table(scene, library))
    light = light_on(scene, solids, surface, size, rng, second)
    colours = surface.albedo * (light + materials.glow[surface.material])
    add_mirrored(scene, geometry, materials, solids, surface, directions, colours, size, library)
    if scene.haze_m < 1e5:
        share = np.exp(surface.distance_m / np.float32(-scene.haze_m))
        colours = colours * share + vector(scene.sky.horizon)[:, None] * 0.8 * (1 - share)
    sky = np.flatnonzero(~surface.met)
    if len(sky):
        colours[:, sky] = sky_colours(scene.sky, directions[:, sky].T, library).T
    picture = cv2.merge(list(colours.reshape(3, *size)))
    return np.asarray(cv2.resize(picture, camera.size[::-1], interpolation=cv2.INTER_AREA))
