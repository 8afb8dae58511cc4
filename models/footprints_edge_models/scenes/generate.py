"""Generates one synthetic scene from its number: scene, camera, photo and ground truth."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Size
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.textures.library import SPLITS, TextureLibrary
from footprints_edge_models.scenes.assets.worlds import WorldLibrary
from footprints_edge_models.scenes.ground_truth.pixels import SceneGroundTruth, trace_ground_truth
from footprints_edge_models.scenes.layout.rooms.interior import draw_rooms
from footprints_edge_models.scenes.layout.scene import Scene
from footprints_edge_models.scenes.layout.streets.exterior import draw_street
from footprints_edge_models.scenes.layout.worlds.world_scene import draw_world
from footprints_edge_models.scenes.rendering.cameras import Camera, choose_camera, picture_size
from footprints_edge_models.scenes.rendering.geometry import Geometry, geometry_of
from footprints_edge_models.scenes.rendering.raycast import Triangles
from footprints_edge_models.scenes.rendering.sensor import photograph
from footprints_edge_models.scenes.rendering.shading.render import render

ROOMS_SHARE = 0.6
BESIDE_WORLDS = (0.4, 0.25)
"""Shares of rooms and streets where the library has worlds; these are the rest."""


@dataclass(frozen=True)
class SyntheticScene:
    """A scene with its photo and its ground truth."""

    scene: Scene
    geometry: Geometry = field(repr=False)
    camera: Camera
    image: NDArray[np.uint8] = field(repr=False)
    ground_truth: SceneGroundTruth = field(repr=False)


def generate_scene(library: TextureLibrary, seed: int, number: int, size: Size) -> SyntheticScene:
    """Generate scene ``number`` of a seed; the split of the library is part of the seed.

    Args:
        library: textures of the scene's split.
        seed: seed of the whole set.
        number: number of the scene, from 0.
        size: (H, W) of a landscape picture; portraits and squares have about as many pixels.
    """
    rng = np.random.default_rng((SPLITS.index(library.split), seed, number))
    palette = Palette(library, rng)
    scene = _draw_scene(palette)
    geometry = geometry_of(scene)
    solids = Triangles(geometry.points, geometry.triangles, geometry.holes)
    outlines = Triangles(geometry.outlines)
    camera = choose_camera(scene, geometry, picture_size(size, rng), rng, solids, outlines)
    ground_truth = trace_ground_truth(camera, geometry, solids, outlines)
    image = photograph(render(scene, geometry, solids, camera, library, rng), rng)
    return SyntheticScene(scene, geometry, camera, image, ground_truth)


def _draw_scene(palette: Palette) -> Scene:
    dice, worlds = palette.rng.random(), palette.library.worlds
    if isinstance(worlds, WorldLibrary) and worlds.entries:
        rooms, streets = BESIDE_WORLDS
        if dice >= rooms + streets:
            return draw_world(palette, worlds)
        return draw_rooms(palette) if dice < rooms else draw_street(palette)
    return draw_rooms(palette) if dice < ROOMS_SHARE else draw_street(palette)
