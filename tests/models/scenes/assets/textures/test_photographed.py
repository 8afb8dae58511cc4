"""Photographed textures in place of procedural ones, out of a small pack."""

import json
import pickle

import numpy as np
import pytest
from PIL import Image

from footprints_edge_models.asset_files.pack import AssetPack, pack_assets
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.textures.library import TextureKey, TextureLibrary
from footprints_edge_models.scenes.assets.textures.noise import SIDE_PX
from footprints_edge_models.scenes.assets.textures.photographed import CLASSES, PackPictures
from footprints_edge_models.scenes.layout.streets.exterior import draw_street
from footprints_edge_models.scenes.rendering.look import PHOTO, PLAIN, look_of


@pytest.fixture(scope="module")
def pack_path(tmp_path_factory):
    """Sixteen gradients as floor boards, with a white margin, and sixteen skies."""
    folder = tmp_path_factory.mktemp("assets")
    about = {"licence": "CC0-1.0", "source": "nowhere"}
    (folder / "textures").mkdir()
    boards = []
    for number in range(16):
        picture = np.repeat(np.linspace(60, 200, 128)[:, None], 128, axis=1)[..., None]
        picture = (picture * np.array([1.0, 0.7, 0.5])).astype(np.uint8)
        picture[-12:] = 255
        Image.fromarray(picture).save(folder / f"textures/boards_{number}.jpg", quality=95)
        facts = {"file": f"boards_{number}.jpg", "cls": "woodfloor", "use": "floor"}
        boards.append(facts | about | {"author": f"Maker {number}"})
    (folder / "textures/index.json").write_text(json.dumps(boards))
    (folder / "panoramas").mkdir()
    skies = []
    for number in range(16):
        picture = np.full((64, 128, 3), (100, 130, 190), np.uint8)
        Image.fromarray(picture).save(folder / f"panoramas/sky_{number}.jpg")
        facts = {
            "file": f"sky_{number}.jpg",
            "projection": "equirectangular",
            "shows": "sky",
            "setting": "outdoor" if number < 12 else "indoor",
        }
        skies.append(facts | about | {"author": "Painter"})
    (folder / "panoramas/index.json").write_text(json.dumps(skies))
    path = tmp_path_factory.mktemp("packed") / "assets.zip"
    pack_assets([folder], path)
    return path


def library_of(path, split="train"):
    return TextureLibrary(split, pictures=PackPictures(path, split))


def test_boards_are_mostly_photographed_and_of_their_own_size(pack_path):
    library = library_of(pack_path)
    palette = Palette(library, np.random.default_rng(0))
    floors = [palette.of("planks", tile_m=(5.0, 9.0)) for _ in range(100)]
    taken = [floor for floor in floors if floor.texture.picture]
    assert 60 < len(taken) < 90
    low, high = CLASSES["planks"]["woodfloor"]
    assert all(low <= floor.tile_m <= high for floor in taken)
    assert not palette.of("metal").texture.picture  # there is no photograph of that


def test_each_split_has_its_own(pack_path):
    def drawn(split):
        library, rng = library_of(pack_path, split), np.random.default_rng(0)
        return {library.any_of(rng, "planks").picture for _ in range(300)} - {""}

    train, test = drawn("train"), drawn("test")
    assert train and test and not train & test
    assert train == {entry.key for entry in AssetPack(pack_path).of("texture", "train")}


def test_a_tile_has_no_margin_and_no_seam(pack_path):
    pictures = PackPictures(pack_path, "train")
    key = AssetPack(pack_path).of("texture", "train")[0].key
    for variant in range(3):
        tile = pictures.texture(key, variant).astype(int)
        assert tile.shape == (SIDE_PX, SIDE_PX, 3)
        assert tile.min(axis=2).mean(axis=1).max() < 200
        over = np.abs(tile[0] - tile[-1]).mean()
        assert over < 25  # the gradient alone would step by about 140
    tiles = [pictures.texture(key, variant) for variant in (0, 0, 1)]
    assert (tiles[0] == tiles[1]).all() and (tiles[0] != tiles[2]).any()
    again = pickle.loads(pickle.dumps(pictures))
    assert (again.texture(key, 1) == tiles[2]).all()


def test_scenes_stand_below_photographed_skies_and_name_what_they_show(pack_path):
    library = library_of(pack_path)
    scenes = [draw_street(Palette(library, np.random.default_rng(seed))) for seed in range(8)]
    skies = {scene.sky.backdrop.panorama for scene in scenes if scene.sky.backdrop}
    assert skies <= set(library.pictures.panoramas) and len(skies) > 1
    for scene in scenes:
        if scene.sky.backdrop:
            assert scene.sky.backdrop.panorama in scene.assets()
    assert any(name.startswith("boards") for scene in scenes for name in scene.assets())


def test_only_scenes_from_assets_have_the_look_of_photos(pack_path):
    assert look_of(library_of(pack_path)) is PHOTO
    plain = TextureLibrary("train")
    assert look_of(plain) is PLAIN
    assert not plain.any_of(np.random.default_rng(0), "planks").picture
    assert plain.draw(TextureKey("planks", 1)).shape == (SIDE_PX, SIDE_PX, 3)
