"""3D models in scenes: a red box with a two-coloured texture stands where a chair would."""

import json
import pickle
import zipfile

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from footprints_edge_models.asset_files.pack import AssetPack, pack_assets
from footprints_edge_models.cli import app
from footprints_edge_models.scenes.assets import models
from footprints_edge_models.scenes.assets.furniture import seating
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.models import ModelLibrary
from footprints_edge_models.scenes.assets.people import seated_parts
from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.assets.things import extended
from footprints_edge_models.scenes.generate import generate_scene
from footprints_edge_models.scenes.ground_truth import pixels
from footprints_edge_models.scenes.layout.rooms.interior import draw_rooms
from footprints_edge_models.scenes.rendering.geometry import geometry_of

BOX = """mtllib chair.mtl
v -1 0 -1
v 1 0 -1
v 1 2 -1
v -1 2 -1
v -1 0 1
v 1 0 1
v 1 2 1
v -1 2 1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl cloth
f 5/1 6/2 7/3 8/4
f 2/1 1/2 4/3 3/4
f 4/1 8/2 7/3 3/4
f 1/1 5/2 8/3 4/4
f 6/1 2/2 3/3 7/4
f 1/1 2/2 6/3 5/4
"""


@pytest.fixture(scope="module")
def pack_path(tmp_path_factory):
    """Sixteen chairs, so that both splits have some."""
    folder = tmp_path_factory.mktemp("assets")
    texture = np.zeros((64, 64, 3), np.uint8)
    texture[:32], texture[32:] = (220, 30, 30), (30, 30, 220)  # red above, blue below
    Image.fromarray(texture).save(folder / "cloth.png")
    lines = ["name=Test", "license=Public domain"]
    with zipfile.ZipFile(folder / "chairs.sh3f", "w") as archive:
        for number in range(1, 17):
            lines += [
                f"id#{number}=Test#chair{number}",
                f"name#{number}=Chair",
                f"category#{number}=Office",
                f"model#{number}=/chair.obj",
                f"width#{number}=45",
                f"depth#{number}=50",
                f"height#{number}=90",
                f"creator#{number}=Maker {number}",
            ]
        archive.writestr("PluginFurnitureCatalog.properties", "\n".join(lines))
        archive.writestr("chair.obj", BOX)
        archive.writestr("chair.mtl", "newmtl cloth\nKd 1 1 1\nmap_Kd cloth.png\n")
        archive.writestr("cloth.png", (folder / "cloth.png").read_bytes())
    pack_assets([folder], folder / "assets.zip")
    return folder / "assets.zip"


@pytest.fixture
def chair(pack_path, monkeypatch):
    """A chair that is a model for sure."""
    monkeypatch.setattr(models, "MODELS_SHARE", 1.0)
    library = TextureLibrary("train", models=ModelLibrary(pack_path, "train"))
    palette = Palette(library, np.random.default_rng(0))
    found = next(c for c in (seating.chair(palette) for _ in range(40)) if c.asset)
    return found, library


def test_a_model_stands_in_place_of_a_chair_in_its_own_size(chair):
    thing, _ = chair
    assert thing.label == "chair" and thing.asset.startswith("chairs/chair")
    low, high = thing.extent
    np.testing.assert_allclose(low, (-0.225, -0.25, 0), atol=1e-4)
    np.testing.assert_allclose(high, (0.225, 0.25, 0.9), atol=1e-4)


def test_its_ground_truth_is_that_of_a_box(chair, scene_of, camera, truth_for):
    thing, _ = chair
    found = truth_for(scene_of(thing.at(0.0, 4.0)), camera)
    middle = found.bits[:, camera.size[1] // 2]
    footprint = middle & pixels.FOOTPRINT > 0
    hidden = (middle & pixels.GROUND_ANYWHERE > 0) & (middle & pixels.VISIBLE_GROUND == 0)
    assert footprint.any() and hidden.any()
    assert np.flatnonzero(hidden).max() < np.flatnonzero(footprint).min()  # farther is higher up
    depth_m = found.ground_depth_m[:, camera.size[1] // 2]
    # the ray to the rear edge of the base passes 1.5 m above to 0 m at y = 4.25
    rear = np.flatnonzero(footprint).min()
    angle = np.radians(20)
    expected_m = 4.25 * np.cos(angle) + 1.5 * np.sin(angle)
    assert depth_m[rear] == pytest.approx(expected_m, rel=0.06)


def test_its_texture_is_the_right_way_up(chair, scene_of, camera):
    from footprints_edge_models.scenes.rendering.look import PLAIN
    from footprints_edge_models.scenes.rendering.raycast import Triangles
    from footprints_edge_models.scenes.rendering.shading.render import render

    thing, library = chair
    scene = scene_of(thing.at(0.0, 2.5))
    geometry = geometry_of(scene)
    solids = Triangles(geometry.points, geometry.triangles)
    light = render(scene, geometry, solids, camera, library, PLAIN, np.random.default_rng(0))
    front = light[:, camera.size[1] // 2]
    red, blue = (front[:, a] > 2 * front[:, b] for a, b in ((0, 2), (2, 0)))
    assert red.sum() > 3 and blue.sum() > 3
    assert np.flatnonzero(red).mean() < np.flatnonzero(blue).mean()


def test_every_process_makes_the_same_scene(pack_path):
    library = TextureLibrary("train", models=ModelLibrary(pack_path, "train"))
    first = generate_scene(library, 3, 1, (64, 112))
    copied = pickle.loads(pickle.dumps(library))
    again = generate_scene(copied, 3, 1, (64, 112))
    np.testing.assert_array_equal(first.image, again.image)
    np.testing.assert_array_equal(first.ground_truth.bits, again.ground_truth.bits)


def test_the_splits_share_no_model(pack_path):
    pack = AssetPack(pack_path)
    train, test = ({entry.key for entry in pack.of("model", split)} for split in ("train", "test"))
    assert train and test and not train & test


def test_the_command_furnishes_from_a_pack_and_credits_what_it_used(pack_path, tmp_path):
    folder = tmp_path / "scenes"
    command = ["scenes", str(folder), "--count", "3", "--seed", "5", "--size", "64x112", "-j", "1"]
    made = CliRunner().invoke(app, [*command, "--assets", str(pack_path)])
    assert made.exit_code == 0, made.output
    credits = json.loads((folder / "credits.json").read_text())
    assert all(each["licence"] == "CC0-1.0" for each in credits)
    train = {entry.credit.author for entry in AssetPack(pack_path).of("model", "train")}
    assert {each["author"] for each in credits} <= train
    other = CliRunner().invoke(app, command)  # without the pack they would be other scenes
    assert other.exit_code == 2 and "begun" in other.output


def test_the_command_packs_folders_by_itself(pack_path, tmp_path):
    folder = tmp_path / "scenes"
    command = ["scenes", str(folder), "--count", "1", "--size", "64x112", "-j", "1"]
    made = CliRunner().invoke(app, [*command, "--assets", str(pack_path.parent)])
    assert made.exit_code == 0, made.output
    assert (folder / "assets.zip").is_file()
    packed = CliRunner().invoke(
        app, ["assets", str(pack_path.parent), "-o", str(tmp_path / "a.zip")]
    )
    assert json.loads(packed.stdout)["models"] == 16


def test_somebody_on_a_model_of_a_chair_leaves_its_footprint_and_its_credit_alone(chair):
    thing, _ = chair
    rng = np.random.default_rng(0)
    palette = Palette(TextureLibrary("train"), rng)
    seated = extended(thing, "person", seated_parts(palette, 0.45))
    assert (seated.label, seated.asset) == ("person", thing.asset)
    taken = [outline.tolist() for outline in seated.footprints()]
    assert all(outline.tolist() in taken for outline in thing.footprints())
    area = sum(np.prod(np.ptp(outline, axis=0)) for outline in seated.footprints())
    assert area < 0.45 * 0.5 + 0.2  # the chair's and the feet's, not the whole person's


def test_every_texture_of_a_model_in_a_scene_is_credited(pack_path, monkeypatch):
    monkeypatch.setattr(models, "MODELS_SHARE", 1.0)
    library = TextureLibrary("train", models=ModelLibrary(pack_path, "train"))
    shown = 0
    for number in range(12):
        scene = draw_rooms(Palette(library, np.random.default_rng((7, number))))
        credited = {thing.asset for thing in scene.things}
        kinds = {part.material.texture.kind for thing in scene.things for part in thing.parts}
        textured = {kind.removeprefix("model:") for kind in kinds if kind.startswith("model:")}
        assert textured <= credited
        shown += len(textured)
    assert shown


def test_what_hangs_on_a_wall_takes_no_place_of_what_stands(pack_path):
    library = ModelLibrary(pack_path, "train")
    size_m = np.array([0.45, 0.5, 0.9])
    assert library.matching(["chair"], size_m, stands=True)
    assert not library.matching(["chair"], size_m, stands=False)
