"""Renders models into a photo: their colours in its light, and their shadows on its floor."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.insertion.labels import InsertedLabels
from footprints_edge_models.insertion.photo_floor import InsertionError, PhotoFloor
from footprints_edge_models.scenes.assets.materials import Material
from footprints_edge_models.scenes.assets.textures.library import TextureKey, TextureLibrary
from footprints_edge_models.scenes.assets.things import Patch, Thing, rectangle
from footprints_edge_models.scenes.ground_truth.pixels import FOOTPRINT, trace_ground_truth
from footprints_edge_models.scenes.layout.scene import Lamp, Scene, Sky
from footprints_edge_models.scenes.rendering.geometry import Geometry, geometry_of
from footprints_edge_models.scenes.rendering.look import PLAIN
from footprints_edge_models.scenes.rendering.raycast import Floats32, Triangles
from footprints_edge_models.scenes.rendering.sensor import with_shoulder
from footprints_edge_models.scenes.rendering.shading.render import render

LEAST_SHOWN = 0.01
"""Least share of the picture that the models must fill."""
_GAMMA = 2.2
_DARKEST_SHADOW = 0.25
_REACH_M = 120.0


@dataclass(frozen=True)
class Composite:
    """A photo with models in it, uint8 (H, W, 3), RGB, and its labels."""

    image: NDArray[np.uint8] = field(repr=False)
    labels: InsertedLabels = field(repr=False)


def compose(
    floor: PhotoFloor, things: Sequence[Thing], library: TextureLibrary, rng: np.random.Generator
) -> Composite:
    """The photo with things standing on its floor.

    Little in the photo can stand before a thing: nearly all of its place that is in view is floor
    that is seen.

    Raises:
        InsertionError: the things fill too little of the picture.
    """
    scene = _scene(floor, things, rng)
    geometry = geometry_of(scene)
    solids = Triangles(geometry.points, geometry.triangles, geometry.holes)
    cover = _cover(floor, geometry, solids)
    shows_model = cover[..., 0] > 0.5
    if shows_model.mean() < LEAST_SHOWN:
        raise InsertionError("the models that fit are too small")
    truth = trace_ground_truth(floor.camera, geometry, solids, Triangles(geometry.outlines))
    taken = ((truth.bits & FOOTPRINT) > 0) & floor.walkable
    labels = InsertedLabels(floor.ids, shows_model, taken)
    return Composite(_picture(floor, scene, (geometry, solids), cover, library, rng), labels)


def _scene(floor: PhotoFloor, things: Sequence[Thing], rng: np.random.Generator) -> Scene:
    """Things on grey ground: two lamps above them indoors, perhaps sun outdoors."""
    ground = Patch(
        rectangle(-_REACH_M / 2, -_REACH_M / 20, _REACH_M / 2, _REACH_M),
        0.0,
        Material(TextureKey("blank", 2), 1.0, (0.6, 0.6, 0.6)),
    )
    height, heading = np.radians(rng.uniform(25, 70)), rng.uniform(0, 2 * np.pi)
    level = np.cos(height)
    sun = 1.2 if floor.outdoors and rng.random() < 0.5 else 0.0
    sky = Sky(
        np.array([np.cos(heading) * level, np.sin(heading) * level, np.sin(height)]),
        (sun, sun, sun),
        (0.7, 0.8, 1.0),
        (0.9, 0.95, 1.0),
        (0.4, 0.4, 0.4),
        2.0,
        TextureKey("clouds", 0),
    )
    x, y = np.mean([thing.pose[:2, 3] for thing in things], axis=0)
    lamps = [] if floor.outdoors else [_lamp(x, y, rng) for _ in range(2)]
    return Scene(
        "street" if floor.outdoors else "rooms",
        (ground,),
        tuple(things),
        tuple(lamps),
        sky,
        (0.55, 0.55, 0.55),
        (),
    )


def _lamp(x: float, y: float, rng: np.random.Generator) -> Lamp:
    right, ahead = rng.normal(0, 1.5, 2)
    power = rng.uniform(1.5, 4)
    centre = (float(x + right), float(y + ahead), float(rng.uniform(2.2, 3.0)))
    return Lamp(centre, (0.8, 0.8, 0.1), (power, 0.96 * power, 0.9 * power))


def _cover(floor: PhotoFloor, geometry: Geometry, solids: Triangles) -> Floats32:
    """How much of each pixel things cover, float32 (H, W, 1), 0 to 1."""
    height, width = floor.camera.size
    hits = solids.first_hits(*floor.camera.rays((2 * height, 2 * width)))
    met = (hits.triangle >= 0) & (geometry.thing[hits.triangle] >= 0)
    fine = met.reshape(2 * height, 2 * width).astype(np.float32)
    return np.asarray(cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA)[..., None])


def _picture(
    floor: PhotoFloor,
    scene: Scene,
    traced: tuple[Geometry, Triangles],
    cover: Floats32,
    library: TextureLibrary,
    rng: np.random.Generator,
) -> NDArray[np.uint8]:
    bare = replace(scene, things=())
    bare_geometry = geometry_of(bare)
    bare_solids = Triangles(bare_geometry.points, bare_geometry.triangles)
    seed = int(rng.integers(1 << 30))  # the same noise in both: their quotient has little
    light, lit = (
        render(of, geometry, solids, floor.camera, library, PLAIN, np.random.default_rng(seed))
        for of, geometry, solids in ((scene, *traced), (bare, bare_geometry, bare_solids))
    )
    photo = np.asarray((floor.image / np.float32(255)) ** np.float32(_GAMMA), np.float32)
    shadow = np.clip(light / np.maximum(lit, 1e-3), _DARKEST_SHADOW, 1.05)
    shadow = cv2.GaussianBlur(shadow, (0, 0), 1.0)
    shaded = photo * np.where(floor.walkable[..., None], shadow, 1)
    mixed = shaded * (1 - cover) + _in_light_of(photo, light, lit, floor, cover, rng) * cover
    levels = np.clip(mixed, 0, 1) ** (1 / _GAMMA) * 255
    # no sharper, and no cleaner, than the photo
    near = cv2.dilate(cover, np.ones((3, 3), np.uint8))[..., None]
    soft = cv2.GaussianBlur(levels, (0, 0), float(rng.uniform(0.4, 0.8)))
    grain = rng.normal(0, rng.uniform(0.5, 3), (*floor.camera.size, 1))
    levels = levels * (1 - near) + (soft + grain) * near
    return np.asarray(np.clip(levels + 0.5, 0, 255), np.uint8)


def _in_light_of(
    photo: Floats32,
    light: Floats32,
    lit: Floats32,
    floor: PhotoFloor,
    cover: Floats32,
    rng: np.random.Generator,
) -> Floats32:
    """The models' light as the photo's camera would have taken it, linear (H, W, 3).

    As bright as the grey ground would be beside the photo's floor, and a little of its hue.
    """
    seen = floor.mask & (cover[..., 0] < LEAST_SHOWN)
    if not seen.any():
        seen = floor.mask
    gain = float(np.median(photo[seen])) / max(float(np.median(lit[seen])), 1e-3)
    gain = float(np.clip(gain * np.exp(rng.normal(0.25, 0.35)), 0.15, 1.6))
    mean = photo.reshape(-1, 3).mean(axis=0)
    tint = np.clip(mean / max(float(mean.mean()), 1e-3), 0.5, 2) ** 0.3
    return with_shoulder(light * np.float32(gain) * tint.astype(np.float32))
