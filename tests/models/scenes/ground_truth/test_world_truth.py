"""Ground truth in worlds against a map made in another way: rays from above and across.

The truth projects triangles of a band of heights onto the plan when a world is packed. Here the
finished scene is looked at from above, a cell of a grid each ray; rays from cell to cell find what
is thin and upright. WORLD_PICTURES=50 checks so many pictures, of all worlds; their figures are
printed with -s.
"""

import os
from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

from footprints_edge_models.asset_files.glb import read_world
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.assets.worlds import loaded
from footprints_edge_models.scenes.ground_truth import pixels
from footprints_edge_models.scenes.ground_truth.pixels import trace_ground_truth
from footprints_edge_models.scenes.layout.worlds.world_scene import world_scene
from footprints_edge_models.scenes.rendering.cameras import choose_camera
from footprints_edge_models.scenes.rendering.geometry import geometry_of
from footprints_edge_models.scenes.rendering.raycast import Triangles

FOLDER = Path(__file__).resolve().parents[5] / "shared/assets/worlds"
pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason=f"no worlds in {FOLDER}")

PICTURES = int(os.environ.get("WORLD_PICTURES", "3"))
QUICK = ("living-room-3", "dining-room", "tmc-home")
CELL_M, REACH_M = 0.02, 6.0
"""Of the map indoors; it is twice as wide outdoors, with as many cells."""
NEAR_EDGE = 2
"""Cells beside an edge of the map are not judged: outlines are drawn in cells of 2 cm, too."""
VEHICLES = {"car", "bus", "van", "truck", "lorry"}


def names():
    found = sorted(path.name.removesuffix(".glb") for path in FOLDER.glob("*.glb"))
    chosen = QUICK if len(QUICK) >= PICTURES else found
    return [chosen[k % len(chosen)] for k in range(PICTURES)]


@pytest.fixture(scope="module")
def world_of():
    known = {}

    def get(name):
        if name not in known:
            known.clear()
            known[name] = loaded(read_world(FOLDER / f"{name}.glb"))
        return known[name]

    return get


def test_what_stands_on_a_floor_is_what_is_seen_there_from_above(world_of):
    right = {True: 0, False: 0}
    total = {True: 0, False: 0}
    for number, name in sorted(enumerate(names()), key=lambda pair: pair[1]):
        free, taken, judged = compared(world_of(name), number)
        print(f"{name:14s} {number:3d}", *(f"{k}: {free[k]}/{judged[k]}" for k in (False, True)))
        for kind, good in ((False, free[False]), (True, taken)):
            right[kind] += good
            total[kind] += judged[kind]
    agreement = {kind: right[kind] / max(total[kind], 1) for kind in right}
    print("free ground", agreement[False], total[False], "footprints", agreement[True], total[True])
    assert total[False] > 1000 and total[True] > 100
    assert agreement[False] > 0.98 and agreement[True] > 0.98


def compared(world, number):
    """Pixels that the map calls free by truth's kind, taken where truth says so, and all judged."""
    rng = np.random.default_rng((12, number))
    scene = world_scene(Palette(TextureLibrary("train"), rng), world)
    geometry = geometry_of(scene)
    solids = Triangles(geometry.points, geometry.triangles, geometry.holes)
    outlines = Triangles(geometry.outlines)
    camera = choose_camera(scene, geometry, (90, 120), rng, solids, outlines)
    truth = trace_ground_truth(camera, geometry, solids, outlines)
    origins, directions = camera.rays()
    met = truth.ground_depth_m.ravel() > 0
    points = origins[met] + directions[met] * truth.ground_depth_m.ravel()[met, None]
    level = scene_level(scene, camera)
    taken, known = map_from_above(scene, geometry, camera, level, outdoors=world.outdoors)
    scale = 2 if world.outdoors else 1
    way = (points[:, :2] - camera.position_m[:2]) / scale
    cells = np.floor((way + REACH_M) / CELL_M).astype(int)
    size = len(taken)
    inside = ((cells >= 0) & (cells < size)).all(axis=1) & (np.abs(points[:, 2] - level) < 0.4)
    x, y = cells[inside].T
    bits = truth.bits.ravel()[met][inside]
    sure = known[y, x]
    says_taken, is_taken = (bits & pixels.FOOTPRINT > 0)[sure], taken[y, x][sure]
    judged = {False: int((~says_taken).sum()), True: int(says_taken.sum())}
    free = {kind: int((~is_taken & (says_taken == kind)).sum()) for kind in (False, True)}
    return free, judged[True] - free[True], judged


def scene_level(scene, camera):
    places = scene.standpoints
    away = [np.hypot(p.x0 - camera.position_m[0], p.y0 - camera.position_m[1]) for p in places]
    return places[int(np.argmin(away))].level_m


def map_from_above(scene, geometry, camera, level, *, outdoors):
    """Which cells around the camera are taken, and which are sure, bool (S, S) both."""
    things = geometry.thing
    upright = Triangles(geometry.corners[things >= 0])
    scale = 2 if outdoors else 1
    cell_m, reach_m = scale * CELL_M, scale * REACH_M
    size = round(2 * reach_m / cell_m)
    offsets = (np.arange(size) + 0.5) * cell_m - reach_m
    grid_x, grid_y = np.meshgrid(offsets + camera.position_m[0], offsets + camera.position_m[1])
    at = np.column_stack([grid_x.ravel(), grid_y.ravel()])
    floor_m = floors_under(geometry, at, level)
    there = np.isfinite(floor_m)
    floor_m = np.where(there, floor_m, level)

    def from_height(tracer, height, down_to):
        start = np.column_stack([at, floor_m + height]).astype(np.float32)
        down = np.repeat(np.array([[0, 0, -1]], np.float32), len(at), axis=0)
        return tracer.blocked(start, down, np.full(len(at), height - down_to, np.float32))

    taken = from_height(upright, 0.35, 0.02)
    for height in (0.03, 0.1, 0.2, 0.3):
        for way in ((1, 0, 0), (0, 1, 0)):
            start = np.column_stack([at, floor_m + height]).astype(np.float32)
            start -= np.array(way, np.float32) * cell_m / 2
            ways = np.repeat(np.array([way], np.float32), len(at), axis=0)
            taken |= upright.blocked(start, ways, np.full(len(at), cell_m, np.float32))
    bodies = [k for k, thing in enumerate(scene.things) if thing.label in VEHICLES]
    if bodies:
        body = Triangles(geometry.corners[np.isin(things, bodies)])
        taken |= from_height(body, 0.9, 0.02)
    taken = taken.reshape(size, size)
    patches, count = ndimage.label(~taken)
    area_m2 = ndimage.sum_labels(np.ones_like(patches), patches, np.arange(count + 1)) * cell_m**2
    edge = np.unique(np.concatenate([patches[[0, -1]].ravel(), patches[:, [0, -1]].ravel()]))
    enclosed = area_m2 < 0.8
    if outdoors:
        enclosed = np.ones(count + 1, bool)
        enclosed[patches[size // 2, size // 2]] = False
    enclosed[edge] = False
    enclosed[0] = False
    taken |= enclosed[patches]
    around = np.ones((2 * NEAR_EDGE + 1,) * 2, bool)
    sure = ndimage.binary_erosion(taken, around) | ~ndimage.binary_dilation(taken, around)
    if outdoors:  # what the map's edge cuts may be the inside of a house
        cut = np.isin(patches, edge[edge > 0]) & (patches != patches[size // 2, size // 2])
        sure &= ~ndimage.binary_dilation(cut, around)
    people = [k for k, thing in enumerate(scene.things) if thing.label == "person"]
    legs = geometry.outlines[np.isin(geometry.outline_thing, people)]
    if len(legs):  # built ones take as much ground as a leg is wide at its widest
        start = np.column_stack([at, floor_m - 0.5]).astype(np.float32)
        up = np.repeat(np.array([[0, 0, 1]], np.float32), len(at), axis=0)
        theirs = Triangles(legs).blocked(start, up, np.ones(len(at), np.float32))
        sure &= ~ndimage.binary_dilation(theirs.reshape(size, size), around)
    return taken, sure & there.reshape(size, size)


def floors_under(geometry, at, level):
    floors = Triangles(geometry.corners[geometry.thing == -1])
    start = np.column_stack([at, np.full(len(at), level + 0.5)]).astype(np.float32)
    hits = floors.first_hits(start, np.repeat(np.array([[0, 0, -1]], np.float32), len(at), axis=0))
    found = level + 0.5 - hits.distance
    return np.where(np.abs(found - level) < 0.5, found, np.nan)
