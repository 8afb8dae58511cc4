"""Generates one synthetic scene from its number: scene, camera, photo and ground truth."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Size
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.textures.library import SPLITS, TextureLibrary
from footprints_edge_models.scenes.ground_truth.pixels import SceneGroundTruth, trace_ground_truth
from footprints_edge_models.scenes.layout.rooms.interior import draw_rooms
from footprints_edge_models.scenes.layout.scene import Scene
from footprints_edge_models.scenes.layout.streets.exterior import draw_street
from footprints_edge_models.scenes.rendering.cameras import Camera, choose_camera, picture_size
from footprints_edge_models.scenes.rendering.geometry import Geometry, geometry_of
from footprints_edge_models.scenes.rendering.look import look_of
from footprints_edge_models.scenes.rendering.raycast import Triangles
from footprints_edge_models.scenes.rendering.shading.render import render

ROOMS_SHARE = 0.6


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
    scene = draw_rooms(palette) if rng.random() < ROOMS_SHARE else draw_street(palette)
    geometry = geometry_of(scene)
    solids = Triangles(geometry.points, geometry.triangles)
    outlines = Triangles(geometry.outlines)
    camera = choose_camera(scene, geometry, picture_size(size, rng), rng, solids, outlines)
    ground_truth = trace_ground_truth(camera, geometry, solids, outlines)
    look = look_of(library)
    image = look.photograph(render(scene, geometry, solids, camera, library, look, rng), rng)
    return SyntheticScene(scene, geometry, camera, image, ground_truth)
