"""Things put into the example photo, and the dataset that comes of it."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from footprints_edge.model import load
from footprints_edge_models.asset_files.asset import AssetError
from footprints_edge_models.asset_files.credit_files import read_credits_file
from footprints_edge_models.asset_files.pack import AssetPack, pack_assets
from footprints_edge_models.data.readers.labelled_photos import ADE20K, read_inserted
from footprints_edge_models.insertion.make import InsertJob, insert_models
from footprints_edge_models.insertion.photo_floor import InsertionError, find_floor
from footprints_edge_models.sample import FOOTPRINT, NO, YES
from footprints_edge_models.scenes.assets.textures.library import TextureLibrary

ROOM = Path(__file__).parents[3] / "examples" / "room.jpg"
WALL, FLOOR = 1, 4


@pytest.fixture(scope="module")
def photos(tmp_path_factory):
    """The room, labelled by the model's own visible ground, and a photo of nothing but wall."""
    folder = tmp_path_factory.mktemp("photos")
    for part in ("images", "labels"):
        (folder / part).mkdir()
    image = Image.open(ROOM).resize((480, 360))
    seen = load(threads=1).predict(np.asarray(image)).visible_ground_probability
    ids = np.where(cv2.resize(np.asarray(seen, np.float32), image.size) > 0.5, FLOOR, WALL)
    for name, labels in (("room", ids), ("wall", np.full_like(ids, WALL))):
        image.save(folder / "images" / f"{name}.jpg")
        Image.fromarray(labels.astype(np.uint8)).save(folder / "labels" / f"{name}.png")
    return folder


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    """A pack with nothing but a texture."""
    folder = tmp_path_factory.mktemp("assets")
    texture = {"file": "one.jpg", "cls": "woodfloor", "use": "floor"}
    texture |= {"licence": "CC0-1.0", "author": "Somebody", "source": "somewhere"}
    (folder / "textures").mkdir()
    Image.new("RGB", (64, 32)).save(folder / "textures" / "one.jpg")
    (folder / "textures" / "index.json").write_text(json.dumps([texture]))
    pack_assets([folder], folder / "pack.zip")
    return AssetPack(folder / "pack.zip")


@pytest.fixture(scope="module")
def made(photos, pack, tmp_path_factory):
    """The job, and why pictures were left out by their number."""
    folder = tmp_path_factory.mktemp("inserted")
    pictures = tuple(sorted((photos / "images").iterdir()))
    job = InsertJob(pictures, folder, TextureLibrary("train"), None, seed=3)
    said = {}
    insert_models(job, pack, 2, 1, lambda outcome: said.update({outcome.item: outcome.result}))
    return job, said


def test_the_room_is_furnished_and_the_wall_left_out(made):
    job, said = made
    assert [said[number] == "" for number in range(4)] == [True, False, True, False]
    assert "ground" in said[1] or "floor" in said[1]
    assert sorted(file.name for file in (job.folder / "images").iterdir()) == [
        "room_0.jpg",
        "room_1.jpg",
    ]


def test_a_second_run_keeps_what_is_there(made, pack):
    job, _ = made
    before = {file: file.read_bytes() for file in job.folder.rglob("*.*")}
    states = {}
    insert_models(job, pack, 2, 1, lambda outcome: states.update({outcome.item: outcome.state}))
    assert [states[number] for number in range(4)] == ["kept", "done", "kept", "done"]
    assert {file: file.read_bytes() for file in job.folder.rglob("*.*")} == before


def test_a_folder_is_not_continued_with_other_settings(made, pack):
    job, _ = made
    with pytest.raises(AssetError, match="begun with"):
        insert_models(replace(job, seed=4), pack, 2, 1, lambda _outcome: None)


def test_training_learns_that_floor_goes_on_behind_and_that_footprints_are_none(made):
    job, _ = made
    for sample in read_inserted(job.folder, ADE20K):
        hidden = (sample.ground == YES) & (sample.visible_ground == NO)
        taken = sample.ground == FOOTPRINT
        assert hidden.mean() > 0.003
        assert taken.any()
        assert (sample.visible_ground[taken] == NO).all()
        assert ((sample.visible_ground == YES) & (sample.ground == YES)).mean() > 0.05


def test_photos_models_and_textures_are_credited(made, photos, pack):
    job, _ = made
    credits = job.folder / "credits.json"
    assert [each.title for each in read_credits_file(credits)] == [photos.name]

    # as if one of the things had the texture on it
    things = next((job.folder / "things").iterdir())
    things.write_text(json.dumps([{"label": "rug", "assets": [pack.entries[0].key]}]))
    insert_models(job, pack, 1, 1, lambda _outcome: None)
    assert {each.author for each in read_credits_file(credits)} == {"Somebody", "not stated"}


def test_ids_that_would_mean_models_are_refused(photos):
    image = np.asarray(Image.open(photos / "images" / "room.jpg"))
    with pytest.raises(InsertionError, match="255"):
        find_floor(image, np.full(image.shape[:2], 255, np.uint8), load(threads=1))
