"""A scene in a whole place from files: as it is, or changed, in other light."""

import numpy as np

from footprints_edge_models.asset_files.glb import Viewpoint
from footprints_edge_models.asset_files.pack import TOWN
from footprints_edge_models.asset_files.world_plan import STOREY_M
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.things import Thing
from footprints_edge_models.scenes.assets.worlds import LoadedWorld, WorldLibrary, WorldThing
from footprints_edge_models.scenes.layout.scene import Lamp, Scene, Standpoint
from footprints_edge_models.scenes.layout.skies import draw_sky
from footprints_edge_models.scenes.layout.worlds.changes import (
    floor_materials,
    furnished,
    papered,
    rearranged,
    resurfaced,
)
from footprints_edge_models.scenes.layout.worlds.free_ground import FreeGround
from footprints_edge_models.scenes.layout.worlds.lighting import hang_lamps

TOWNS_SHARE = 0.4
HEIGHTS_M = (0.3, 1.9)
"""Cameras stand this high."""
NEAR_M = 18.0
"""The cameras of one scene in a town stand within this distance of one of them."""
IN_VIEW_M = {"small": 55.0, "wall": 120.0, "tall": 75.0}
"""Things of a town that are farther away are left out."""

_TALL_M = 3.0


def draw_world(palette: Palette, library: WorldLibrary) -> Scene:
    """A scene in one of the worlds of the split."""
    rng = palette.rng
    towns = [entry for entry in library.entries if entry.category == TOWN]
    inside = [entry for entry in library.entries if entry.category != TOWN]
    chosen = towns if towns and (not inside or rng.random() < TOWNS_SHARE) else inside
    return world_scene(palette, library.load(chosen[int(rng.integers(len(chosen)))].key))


def world_scene(palette: Palette, world: LoadedWorld) -> Scene:
    """A scene in this world."""
    rng = palette.rng
    ground = FreeGround.of(world)
    places = _standpoints(world, rng)
    focus = np.array([places[0].x0, places[0].y0])
    near = _in_view(world, focus)
    share = float(rng.choice([0.0, 0.15, 0.4], p=[0.4, 0.35, 0.25]))
    things: list[Thing] = rearranged(palette, ground, near, share)
    if rng.random() < 0.75:
        things += furnished(palette, world, ground, places)
    materials = floor_materials(palette, world)
    if not world.outdoors and rng.random() < 0.4:
        things = papered(palette, things)
    things += world.taken
    sky = draw_sky(palette, bright=1.2 if world.outdoors else 2.5)
    lamps: list[Lamp] = []
    if world.outdoors:
        ambient = np.array(sky.zenith) * 0.35 + np.array(sky.horizon) * 0.25
    else:
        hung, lamps = hang_lamps(palette, world, ground, places[0].level_m)
        things += hung
        warm = float(rng.uniform(0.9, 1.06))
        ambient = float(rng.uniform(0.12, 0.4)) * np.array([warm, 1.0, 1 / warm])
    red, green, blue = (float(value) for value in ambient)
    haze = float(rng.choice([1e5, 600.0, 200.0, 90.0], p=[0.45, 0.3, 0.17, 0.08]))
    return Scene(
        "street" if world.outdoors else "rooms",
        (),
        tuple(things),
        tuple(lamps),
        sky,
        (red, green, blue),
        tuple(places),
        haze_m=haze if world.outdoors else 1e6,
        floors=tuple(
            resurfaced(floor, material)
            for floor, material in zip(world.floors, materials, strict=True)
        ),
        kerbs=world.kerbs,
        world=world.key,
    )


def _standpoints(world: LoadedWorld, rng: np.random.Generator) -> list[Standpoint]:
    """Where cameras may stand: in a town near one place, indoors on one storey."""
    views = world.viewpoints
    first = views[int(rng.integers(len(views)))]
    level = _floor_m(first)
    near = [
        view
        for view in views
        if view is not first
        and abs(_floor_m(view) - level) < STOREY_M / 2
        and (not world.outdoors or float(np.linalg.norm(view.eye_m[:2] - first.eye_m[:2])) < NEAR_M)
    ]
    return [_standpoint(view) for view in (first, *near)]


def _standpoint(view: Viewpoint) -> Standpoint:
    x, y = (float(value) for value in view.eye_m[:2])
    ahead = view.look_m - view.eye_m
    heading = float(np.degrees(np.arctan2(ahead[1], ahead[0])))
    return Standpoint(
        x - 0.25, y - 0.25, x + 0.25, y + 0.25, 1.0, _floor_m(view), HEIGHTS_M, (heading,)
    )


def _floor_m(view: Viewpoint) -> float:
    return float(view.eye_m[2]) - view.height_m


def _in_view(world: LoadedWorld, focus: np.ndarray) -> list[WorldThing]:
    """The things that cameras near a place may show."""
    if not world.outdoors:
        return list(world.things)
    found = []
    for each in world.things:
        gap = np.maximum(np.maximum(each.low_m[:2] - focus, focus - each.high_m[:2]), 0)
        kind = "wall" if each.thing.is_wall else "tall" if each.high_m[2] > _TALL_M else "small"
        if float(np.hypot(*gap)) < IN_VIEW_M[kind]:
            found.append(each)
    return found
