"""Rooms as full as real ones: what stands where, and that cameras look at it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from footprints_edge_models.scenes.assets.furniture import beds, storage
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.assets.things import box, joined
from footprints_edge_models.scenes.ground_truth import pixels
from footprints_edge_models.scenes.layout.floor_plans import Rect
from footprints_edge_models.scenes.layout.rooms.interior import draw_rooms
from footprints_edge_models.scenes.layout.rooms.lived_in import furnish_kitchen, furnish_seats
from footprints_edge_models.scenes.layout.rooms.room import Room, place_of
from footprints_edge_models.scenes.layout.scene import Standpoint
from footprints_edge_models.scenes.rendering.cameras import choose_camera
from footprints_edge_models.scenes.rendering.geometry import geometry_of
from footprints_edge_models.scenes.rendering.raycast import Triangles

ROOM = Rect(0, 0, 5, 4)


def palette_of(seed, models=None):
    return Palette(TextureLibrary("train", models=models), np.random.default_rng(seed))


def places(room, label=""):
    found = []
    for thing in room.things:
        if label in thing.label and thing.outlines != ():
            corner = np.concatenate(thing.footprints())
            found.append(Rect(*corner.min(axis=0), *corner.max(axis=0)))
    return found


@pytest.mark.parametrize("side", range(4))
def test_cupboards_fill_a_wall_up_to_what_stands_there(side):
    room = Room(ROOM, "office")
    x, y = room.at_wall(side, 3.0, 0.3)
    room.taken.append(Rect(x, y, x, y).grown(0.25))
    palette = palette_of(0)
    room.run_along_wall(
        side, lambda wide: storage.fitted_cupboard(palette, wide, 0.5, 2.1), 0.55, 9.0
    )
    (thing,) = room.things
    low, high = thing.extent
    assert high[0] - low[0] == pytest.approx(2.7, abs=0.15)
    (place,) = places(room)
    assert not place.meets(room.taken[0])
    gap_m = (ROOM.y1 - place.y1, place.x0, place.y0, ROOM.x1 - place.x1)[side]
    assert 0 <= gap_m < 0.05


def test_cupboards_keep_clear_of_windows_and_worktops_do_not():
    room = Room(ROOM, "kitchen")
    room.openings.append(Rect(1.0, 3.5, 4.0, 4.5))
    assert room.longest_free(0, 0.6, past_windows=True)[1] == pytest.approx(5.0, abs=0.11)
    assert room.longest_free(0, 0.6, past_windows=False)[1] == pytest.approx(1.0, abs=0.11)


def test_a_full_wall_stays_as_it_is():
    room = Room(ROOM, "office", taken=[ROOM])
    room.run_along_wall(0, lambda _: pytest.fail("made"), 0.6, 3.0)
    assert room.things == []


def test_a_kitchen_has_worktops_of_some_metres():
    widths = []
    for seed in range(8):
        room = Room(ROOM, "kitchen")
        furnish_kitchen(palette_of(seed), room)
        widths += [max(p.width, p.depth) for p in places(room, "counter")]
    assert len(widths) >= 8 and np.median(widths) > 2


def test_seats_stand_in_rows_and_clear_of_each_other():
    for seed in range(4):
        room = Room(Rect(0, 0, 8, 7), "seats")
        furnish_seats(palette_of(seed), room)
        chairs = [
            thing for thing in room.things if thing.label in {"chair", "stool", "office chair"}
        ]
        assert len(chairs) >= 8
        assert len({id(chair.parts) for chair in chairs}) == 1  # all alike
        yaws = [np.arctan2(chair.pose[1, 0], chair.pose[0, 0]) for chair in chairs]
        assert np.ptp(np.unwrap(yaws)) < 0.2
        around = [place_of(replace(c, pose=np.eye(3, 4)), *c.pose[:2, 3], yaws[0]) for c in chairs]
        inner = [place.grown(-0.05) for place in around]
        assert not any(a.meets(b) for k, a in enumerate(inner) for b in inner[:k])


def test_no_ground_is_free_below_a_covered_bed(scene_of, camera, truth_for):
    bed = beds.covered_bed(palette_of(1))
    found = truth_for(scene_of(bed.at(0.0, 4.0)), camera)
    free = found.bits & pixels.GROUND_ANYWHERE > 0
    eyes, rays = camera.rays()
    points = (eyes + rays * found.ground_depth_m.reshape(-1, 1)).reshape(*camera.size, 3)
    below = (np.abs(points[..., 0]) < 0.4) & (np.abs(points[..., 1] - 4.0) < 0.9)
    below &= found.ground_depth_m > 0
    assert below.sum() > 50 and not (free & below).any()


@pytest.mark.parametrize("sights", [True, False])
def test_cameras_look_at_the_furniture_from_near(scene_of, plain, sights):
    sofa = joined("sofa", [box(plain, (1.8, 0.9, 0.8), (0, 0, 0))]).at(2.0, 3.0)
    lamp = joined("lamp", [box(plain, (0.4, 0.4, 1.5), (0, 0, 0))]).at(3.2, 3.0)
    place = Standpoint(-9, -9, 9, 9, sights=((2.0, 3.0, 0.9, 0.8),) if sights else ())
    scene = replace(scene_of(sofa, lamp), kind="rooms", standpoints=(place,))
    geometry = geometry_of(scene)
    solids, outlines = Triangles(geometry.points, geometry.triangles), Triangles(geometry.outlines)
    shown = []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        camera = choose_camera(scene, geometry, (60, 80), rng, solids, outlines)
        x, y, ahead = (np.array([2.0, 3.0, 0.4]) - camera.position_m) @ camera.rotation
        k = camera.intrinsics
        across, down = k.fx * x / ahead + k.cx, k.fy * y / ahead + k.cy
        shown.append(0 < ahead < 4 and 0 < across < 80 and 0 < down < 60)
    assert np.mean(shown) >= 0.6 if sights else np.mean(shown) <= 0.4


def test_scenes_without_models_keep_their_rooms():
    for seed in range(3):
        scene = draw_rooms(palette_of(seed))
        assert not any(place.sights for place in scene.standpoints)
        assert not any(thing.label in {"cupboard", "footstool"} for thing in scene.things)
        full = draw_rooms(palette_of(seed, models=SimpleNamespace()))
        assert any(place.sights for place in full.standpoints)
