"""Generates a synthetic scene from its number, and its views: camera, photo and ground truth."""

from collections.abc import Container, Iterator
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
from footprints_edge_models.scenes.rendering.look import look_of
from footprints_edge_models.scenes.rendering.raycast import Triangles
from footprints_edge_models.scenes.rendering.shading.render import render

ROOMS_SHARE = 0.6
BESIDE_WORLDS = (0.4, 0.25)
"""Shares of rooms and streets where the library has worlds; these are the rest."""


@dataclass(frozen=True)
class SyntheticScene:
    """A view of a scene: its photo and its ground truth.

    Attributes:
        view: number of the view, from 0.
        views: how many views the scene has.
        scene: what stands where.
        geometry: its triangles.
        camera: of the photo.
        image: the photo, uint8 (H, W, 3), RGB.
        ground_truth: of the photo.
    """

    view: int
    views: int
    scene: Scene
    geometry: Geometry = field(repr=False)
    camera: Camera
    image: NDArray[np.uint8] = field(repr=False)
    ground_truth: SceneGroundTruth = field(repr=False)


def generate_scene(library: TextureLibrary, seed: int, number: int, size: Size) -> SyntheticScene:
    """Generate the first view of a scene; see :func:`generate_views`."""
    return next(generate_views(library, seed, number, size))


def generate_views(
    library: TextureLibrary,
    seed: int,
    number: int,
    size: Size,
    views: int = 1,
    wanted: Container[int] = range(1 << 30),
) -> Iterator[SyntheticScene]:
    """Generate views of scene ``number`` of a seed; the split of the library is part of the seed.

    The scene is laid out and turned into triangles once. A view is the same whichever others are
    wanted. Where no camera is found that sees something else than those before it, the scene has
    fewer views.

    Args:
        library: textures of the scene's split.
        seed: seed of the whole set.
        number: number of the scene, from 0.
        size: (H, W) of a landscape picture; portraits and squares have about as many pixels.
        views: how many views are looked for.
        wanted: numbers of the views that are photographed, from 0.
    """
    entropy = (SPLITS.index(library.split), seed, number)
    rng = np.random.default_rng(entropy)
    palette = Palette(library, rng)
    scene = _draw_scene(palette)
    geometry = geometry_of(scene)
    solids = Triangles(geometry.points, geometry.triangles, geometry.holes)
    outlines = Triangles(geometry.outlines)
    cameras: list[Camera] = []
    draws = [rng, *(np.random.default_rng((*entropy, view)) for view in range(1, views))]
    for draw in draws:
        camera = choose_camera(
            scene, geometry, picture_size(size, draw), draw, solids, outlines, cameras
        )
        if camera is None:
            break
        cameras.append(camera)
    look = look_of(library)
    for view, (camera, draw) in enumerate(zip(cameras, draws, strict=False)):
        if view in wanted:
            ground_truth = trace_ground_truth(camera, geometry, solids, outlines)
            light = render(scene, geometry, solids, camera, library, look, draw)
            image = look.photograph(light, draw)
            yield SyntheticScene(view, len(cameras), scene, geometry, camera, image, ground_truth)


def _draw_scene(palette: Palette) -> Scene:
    dice, worlds = palette.rng.random(), palette.library.worlds
    if isinstance(worlds, WorldLibrary) and worlds.entries:
        rooms, streets = BESIDE_WORLDS
        if dice >= rooms + streets:
            return draw_world(palette, worlds)
        return draw_rooms(palette) if dice < rooms else draw_street(palette)
    return draw_rooms(palette) if dice < ROOMS_SHARE else draw_street(palette)
