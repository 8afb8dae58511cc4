"""A small world, written as a file, whose truth is known: a hall with an upper floor."""

import json
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from PIL import Image

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.asset_files.asset import Surface
from footprints_edge_models.asset_files.glb import read_world
from footprints_edge_models.asset_files.pack import AssetPack, pack_assets
from footprints_edge_models.asset_files.world_plan import VEHICLE_WORDS, has_word, plan_of
from footprints_edge_models.cli import app
from footprints_edge_models.scenes import generate
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.assets.things import box, joined, rectangle
from footprints_edge_models.scenes.assets.worlds import WorldLibrary, loaded
from footprints_edge_models.scenes.ground_truth import pixels
from footprints_edge_models.scenes.ground_truth.boxes import boxes_of
from footprints_edge_models.scenes.ground_truth.pixels import trace_ground_truth
from footprints_edge_models.scenes.layout.worlds.changes import rearranged
from footprints_edge_models.scenes.layout.worlds.free_ground import FreeGround
from footprints_edge_models.scenes.layout.worlds.world_scene import world_scene
from footprints_edge_models.scenes.rendering.cameras import Camera, looking
from footprints_edge_models.scenes.rendering.geometry import geometry_of
from footprints_edge_models.scenes.rendering.raycast import Triangles
from footprints_edge_models.scenes.storage.files import (
    SceneSettings,
    read_scene,
    write_scene,
    write_settings,
)

SIZE = (72, 96)
UPPER_M = 3.0


def solid(x0, y0, z0, x1, y1, z1, colour=(200, 200, 200)):
    """A box in the axes of scenes, written with y up."""
    mesh = trimesh.creation.box((x1 - x0, z1 - z0, y1 - y0))
    mesh.apply_translation(((x0 + x1) / 2, (z0 + z1) / 2, -(y0 + y1) / 2))
    mesh.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(baseColorFactor=[*colour, 255])
    )
    return mesh


def card():
    """An upright card at y = 2, 2 m wide and high, on whose left half nothing is."""
    picture = np.zeros((8, 8, 4), np.uint8)
    picture[..., :3], picture[:, 4:, 3] = (40, 160, 40), 255
    points = [(-1, 0, -2), (1, 0, -2), (1, 2, -2), (-1, 2, -2)]
    material = trimesh.visual.material.PBRMaterial(
        baseColorTexture=Image.fromarray(picture), alphaMode="MASK"
    )
    uv = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
    return trimesh.Trimesh(
        points,
        [(0, 1, 2), (0, 2, 3)],
        process=False,
        visual=trimesh.visual.TextureVisuals(uv=uv, material=material),
    )


NODES = {
    "floor": ("floor", solid(-4, -4, -0.2, 4, 6, 0)),
    "rug": ("floor", solid(-3.5, 0, 0, -2.5, 1, 0.01)),
    "platform": ("floor", solid(-1, -4, -0.1, 1, -3.2, 0.15)),
    "upper": ("floor", solid(2, 3, UPPER_M - 0.2, 4, 6, UPPER_M)),
    "wall": ("wall", solid(-4, 6, 0, 4, 6.1, 5)),
    "table_top": ("object", solid(1, 0, 0.7, 2, 1, 0.75)),
    **{
        f"table_leg{k}": ("object", solid(x, y, 0, x + 0.1, y + 0.1, 0.7))
        for k, (x, y) in enumerate([(1, 0), (1.9, 0), (1, 0.9), (1.9, 0.9)])
    },
    "cupboard": ("object", solid(3, -3, 0, 3.8, -2.5, 1.8)),
    "wine": ("object", solid(-3, -3, 1, -2.9, -2.9, 1.1)),  # its glass is left out
    "view": ("backdrop", solid(-20, 9, 0, 20, 9.1, 20)),
    "leaves": ("object", card()),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    root = tmp_path_factory.mktemp("worlds")
    scene = trimesh.Scene()
    for name, (_, mesh) in NODES.items():
        scene.add_geometry(mesh, node_name=name, geom_name=name)
    (root / "hall.glb").write_bytes(scene.export(file_type="glb"))
    nodes = [{"name": name, "role": role} for name, (role, _) in NODES.items()]
    nodes[-1]["alpha_mask"] = True
    about = {
        "title": "A hall", "licence": "CC0-1.0", "author": "Somebody", "source": "somewhere",
        "nodes": nodes,
    }  # fmt: skip
    (root / "hall.json").write_text(json.dumps(about))
    cameras = [
        {"position": [x, 1.5, 2.5], "look_at": [0, 1, 0], "eye_height": 1.5} for x in (-2, 0, 2)
    ]
    (root / "hall.cameras.json").write_text(json.dumps({"cameras": cameras}))
    return root


@pytest.fixture(scope="module")
def file(folder):
    return read_world(folder / "hall.glb")


@pytest.fixture(scope="module")
def world(file):
    return loaded(file)


@pytest.fixture(scope="module")
def scene(world):
    """The world as it is: nothing moved, nothing added."""
    made = world_scene(Palette(TextureLibrary("train"), np.random.default_rng(0)), world)
    things = tuple(each.thing for each in world.things) + world.taken
    floors = tuple(floor.part for floor in world.floors)
    return type(made)(
        "rooms", (), things, made.lamps, made.sky, made.ambient, made.standpoints,
        floors=floors, kerbs=world.kerbs,
    )  # fmt: skip


@pytest.fixture(scope="module")
def seen(scene):
    """The truth at a point of the world, looked at from another."""
    geometry = geometry_of(scene)
    solids = Triangles(geometry.points, geometry.triangles, geometry.holes)

    def look(eye, at):
        way = np.subtract(at, eye).astype(float)
        heading, pitch = np.arctan2(way[1], way[0]), -np.arctan2(way[2], np.hypot(*way[:2]))
        camera = Camera(
            np.array(eye, float), looking(heading, pitch, 0.0),
            Intrinsics.from_hfov(1.0, (3, 3)), (3, 3),
        )  # fmt: skip
        truth = trace_ground_truth(camera, geometry, solids, Triangles(geometry.outlines))
        return int(truth.bits[1, 1]), float(truth.ground_depth_m[1, 1])

    return look


def area_m2(plan, thing):
    return sum(
        np.ptp(each.outline[:, 0]) * np.ptp(each.outline[:, 1])
        for each in plan.taken
        if each.thing == thing
    )


def test_parts_that_touch_are_one_thing_and_take_the_ground_below_them(file):
    number = {s.name: n for s, n in zip(file.surfaces, file.plan.thing_of, strict=True)}
    assert number["floor"] == number["rug"] == -1
    assert len({number[name] for name in number if name.startswith("table")}) == 1
    assert number["cupboard"] not in {number["table_top"], number["wall"]}
    assert area_m2(file.plan, number["cupboard"]) == pytest.approx(0.4, rel=0.1)
    assert area_m2(file.plan, number["table_top"]) == pytest.approx(4 * 0.1**2, rel=0.5)
    assert file.plan.storeys_m == pytest.approx((0.0, UPPER_M), abs=0.02)
    assert "view" not in number


def test_a_vehicle_takes_its_whole_outline_and_the_car_of_a_lift_its_walls():
    ends = [trimesh.creation.box((0.2, 1, 1.5)) for _ in range(2)]
    for end, x in zip(ends, (-1, 1), strict=True):
        end.apply_translation((x, 0, 0.75))
    both = trimesh.util.concatenate(ends)
    surface = Surface(
        both.vertices.astype(np.float32), both.faces.astype(np.int32),
        np.zeros((len(both.vertices), 2), np.float32), (90, 90, 90), name="lift_car_1",
    )  # fmt: skip
    town, house = (
        plan_of([surface], np.zeros((0, 3)), outdoors=outdoors) for outdoors in (True, False)
    )
    assert area_m2(town, 0) == pytest.approx(2.2, rel=0.01)
    assert area_m2(house, 0) == pytest.approx(0.4, rel=0.3)


@pytest.mark.parametrize(
    ("name", "is_vehicle"),
    [("city_bus_2", True), ("CityBus", True), ("SUV_black.001", True), ("bush_3", False),
     ("BushLogo", False), ("carpet_1", False), ("cardboard_box", False)],
)  # fmt: skip
def test_vehicles_are_named_by_whole_words(name, is_vehicle):
    assert has_word(name, (*VEHICLE_WORDS, "car")) is is_vehicle


def test_a_box_stands_on_the_floor_of_its_thing(scene, world):
    """What is on an upper floor is not as high as the house."""
    dark = Palette(TextureLibrary("train"), np.random.default_rng(0)).dark()
    size = (0.5, 0.4, 0.6)
    parts, outlines = [box(dark, size, (3, 5, UPPER_M))], (rectangle(2.75, 4.8, 3.25, 5.2),)
    own = joined("box", parts, outlines=outlines, level_m=UPPER_M)
    put = FreeGround.of(world).put(joined("box", [box(dark, size, (0, 0, 0))]), 3, 5, 0.0, UPPER_M)
    eye = np.array([3, 3.5, UPPER_M + 1.5])
    camera = Camera(eye, looking(np.pi / 2, 0.5, 0.0), Intrinsics.from_hfov(70, SIZE), SIZE)
    for thing in (own, put):
        (found,) = boxes_of(replace(scene, things=(thing,)), camera)
        assert found["size_m"] == pytest.approx([0.5, 0.6, 0.4], abs=0.01)
        centre = camera.rotation.T @ (np.array([3, 5, UPPER_M + 0.3]) - eye)
        assert found["centre_m"] == pytest.approx(centre, abs=0.01)


def test_what_floats_is_left_out(world):
    low = [tuple(np.round(each.low_m, 2)) for each in world.things]
    assert (-3.0, -3.0, 1.0) not in low
    assert (3.0, -3.0, 0.0) in low


def test_seen_and_hidden_floor_and_what_stands_there(seen):
    free = pixels.VISIBLE_GROUND | pixels.GROUND_ANYWHERE
    assert seen((0, -2, 1.5), (-1, 0, 0))[0] == free
    assert seen((-3, -2, 1.5), (-3, 0.5, 0.01))[0] == free  # on the rug
    assert seen((-3, -2, 0.3), (-3, 0.0, 0.005))[0] == free  # its edge
    under, depth = seen((1.5, 0.4, 1.5), (1.5, 0.6, 0))  # through the table's top
    assert under == pixels.GROUND_ANYWHERE
    assert depth == pytest.approx(np.hypot(1.5, 0.2), abs=0.01)
    assert seen((1.05, -2, 1.5), (1.05, 0.05, 0))[0] == pixels.FOOTPRINT
    assert seen((0, -3, 1.5), (3.4, -2.75, 0))[0] == pixels.FOOTPRINT


def test_sides_of_floors_and_floors_from_below_are_no_ground(seen):
    assert seen((3, -2, 2.9), (3, 3.0, UPPER_M - 0.1)) == (0, 0.0)
    assert seen((3, 4, 1.0), (3, 4.5, 4.0)) == (0, 0.0)
    # the side of a platform, below which the floor goes on
    assert seen((0, -1, 1.0), (0, -3.2, 0.07)) == (0, 0.0)
    # on the upper floor, above nothing that stands below
    up = seen((3, 4, UPPER_M + 1.5), (3, 5, UPPER_M))
    assert up[0] == pixels.VISIBLE_GROUND | pixels.GROUND_ANYWHERE


def test_a_wall_hides_ground_and_the_cupboard_takes_none_on_another_storey(seen, scene):
    cupboard = next(
        t for t in scene.things if t.outlines and t.extent[0][2] < 0.01 < t.extent[1][2] < 2
    )
    assert cupboard.level_m == pytest.approx(0, abs=0.01)
    assert seen((0, 4, 1.0), (0, 8, 1.0))[0] == 0  # beyond the wall there is no floor


def test_rays_go_through_holes(scene):
    geometry = geometry_of(scene)
    solids = Triangles(geometry.points, geometry.triangles, geometry.holes)
    origins = np.array([(-0.5, 0, 1), (0.5, 0, 1)], np.float32)
    ahead = np.array([[0, 1, 0]], np.float32).repeat(2, axis=0)
    np.testing.assert_allclose(solids.first_hits(origins, ahead).distance, (6, 2), atol=0.01)
    reach = np.full(2, 3, np.float32)
    assert solids.blocked(origins, ahead, reach).tolist() == [False, True]


def test_heights_of_storeys_are_stored(scene, tmp_path):
    geometry = geometry_of(scene)
    solids = Triangles(geometry.points, geometry.triangles, geometry.holes)
    eye = np.array([3.0, 3.5, UPPER_M + 1.5])
    camera = Camera(eye, looking(2.2, 0.6, 0.0), Intrinsics.from_hfov(90, SIZE), SIZE)
    truth = trace_ground_truth(camera, geometry, solids, Triangles(geometry.outlines))
    heights = eye[2] - truth.ground_depth_m  # very roughly: both floors are in view
    assert (truth.ground_depth_m > 0).any() and np.ptp(heights[truth.ground_depth_m > 0]) > 2
    write_settings(tmp_path, SceneSettings("train", 0, SIZE))
    image = np.zeros((*SIZE, 3), np.uint8)
    write_scene(tmp_path, "000000", scene, camera, image, truth, 90)
    again = read_scene(tmp_path, "000000").ground_truth
    np.testing.assert_allclose(again.ground_depth_m, truth.ground_depth_m, rtol=2e-3, atol=2e-3)
    assert (again.bits == truth.bits).all()


def test_things_are_put_on_free_ground_only(world):
    palette = Palette(TextureLibrary("train"), np.random.default_rng(0))
    crate = joined("box", [box(palette.dark(), (0.5, 0.5, 0.5), (0, 0, 0))])
    ground = FreeGround.of(world)
    assert ground.put(crate, 3.4, -2.7, 0.3, 0.0) is None  # in the cupboard
    assert ground.put(crate, 1.5, 0.5, 0.0, 0.0) is not None  # under the table it fits
    assert ground.put(crate, 1.5, 0.6, 0.0, 0.0) is None  # not twice
    assert ground.put(crate, -1, 5.9, 0.0, 0.0) is None  # in the wall
    assert ground.put(crate, 0, 2, 0.0, 0.0) is None  # through the leaves
    assert ground.put(crate, -4, 0, 0.0, 0.0) is None  # over the edge of the floor
    above = ground.put(crate, 3, 4.5, 0.4, UPPER_M)
    assert above is not None and above.level_m == pytest.approx(UPPER_M, abs=0.01)
    assert above.pose[2, 3] == pytest.approx(UPPER_M, abs=0.01)


def test_furniture_is_moved_and_taken_away_with_its_ground(world):
    palette = Palette(TextureLibrary("train"), np.random.default_rng(3))
    left = rearranged(palette, FreeGround.of(world), world.things, 1.0)
    fixed = [each.thing for each in world.things if not each.movable]
    assert all(any(thing is other for other in left) for thing in fixed)
    moved = [thing for thing in left if not any(thing is other for other in fixed)]
    assert moved and len(moved) < sum(each.movable for each in world.things) + 1
    for thing in moved:
        low = min(
            float((part.shape.outline @ part.matrix[:, :3].T + part.matrix[:, 3])[:, 2].min())
            for part in thing.parts
        )
        assert low + thing.pose[2, 3] == pytest.approx(0, abs=0.03)  # it stands on the floor
        assert thing.footprints()


def test_scenes_of_worlds_are_made_again_alike_and_credited(folder, tmp_path, monkeypatch):
    from typer.testing import CliRunner

    monkeypatch.setattr(generate, "BESIDE_WORLDS", (0.0, 0.0))
    pack_assets([folder], tmp_path / "assets.zip")
    arguments = [
        "--count",
        "2",
        "--size",
        "64x96",
        "-j",
        "1",
        "--assets",
        str(tmp_path / "assets.zip"),
    ]
    for name in ("a", "b"):
        done = CliRunner().invoke(app, ["scenes", str(tmp_path / name), *arguments])
        assert done.exit_code == 0, done.output
    for part in ("images/000000.jpg", "truth/000001.npz"):
        assert (tmp_path / "a" / part).read_bytes() == (tmp_path / "b" / part).read_bytes()
    credits = json.loads((tmp_path / "a/credits.json").read_text())
    assert [each["title"] for each in credits] == ["A hall"]


def test_a_world_of_which_only_the_floor_is_in_view_is_credited(world):
    palette = Palette(TextureLibrary("train"), np.random.default_rng(1))
    assert world_scene(palette, replace(world, things=(), taken=())).assets() == ("hall",)


def test_a_process_reads_a_world_once_and_sends_none_to_others(folder, tmp_path):
    import pickle

    pack_assets([folder], tmp_path / "assets.zip")
    library = WorldLibrary(tmp_path / "assets.zip", "train")
    assert library.load("hall") is library.load("hall")
    assert len(pickle.dumps(library)) < 1000
    (entry,) = AssetPack(tmp_path / "assets.zip").entries
    assert entry.category == "interior"
