"""Things put into the example photo, and the dataset that comes of it."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from footprints_edge.model import load
from footprints_edge_models.asset_files.credit_files import read_credits_file
from footprints_edge_models.asset_files.pack import AssetPack, pack_assets
from footprints_edge_models.data.readers.labelled_photos import ADE20K, read_inserted
from footprints_edge_models.insertion.make import InsertJob, credit_insertions, insert_models
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
def made(photos, tmp_path_factory):
    """The job, and why pictures were left out by their number."""
    folder = tmp_path_factory.mktemp("inserted")
    pictures = tuple(sorted((photos / "images").iterdir()))
    job = InsertJob(pictures, folder, TextureLibrary("train"), None, seed=3)
    said = {}
    insert_models(job, 2, 1, lambda outcome: said.update({outcome.item: outcome.result}))
    return job, said


def test_the_room_is_furnished_and_the_wall_left_out(made):
    job, said = made
    assert [said[number] == "" for number in range(4)] == [True, False, True, False]
    assert "wall.jpg" in said[1]
    assert sorted(file.name for file in (job.folder / "images").iterdir()) == [
        "room_0.jpg",
        "room_1.jpg",
    ]


def test_a_second_run_keeps_what_is_there(made):
    job, _ = made
    before = {file: file.read_bytes() for file in job.folder.rglob("*.*")}
    states = {}
    insert_models(job, 2, 1, lambda outcome: states.update({outcome.item: outcome.state}))
    assert [states[number] for number in range(4)] == ["kept", "done", "kept", "done"]
    assert {file: file.read_bytes() for file in job.folder.rglob("*.*")} == before


def test_training_learns_that_floor_goes_on_behind_and_that_footprints_are_none(made):
    job, _ = made
    for sample in read_inserted(job.folder, ADE20K):
        hidden = (sample.ground == YES) & (sample.visible_ground == NO)
        taken = sample.ground == FOOTPRINT
        assert hidden.mean() > 0.003
        assert taken.any()
        assert (sample.visible_ground[taken] == NO).all()
        assert ((sample.visible_ground == YES) & (sample.ground == YES)).mean() > 0.05


def test_photos_and_models_are_credited(made, photos, tmp_path):
    job, _ = made
    texture = {"file": "one.jpg", "cls": "woodfloor", "use": "floor"}
    texture |= {"licence": "CC0-1.0", "author": "Somebody", "source": "somewhere"}
    (tmp_path / "textures").mkdir()
    Image.new("RGB", (64, 32)).save(tmp_path / "textures" / "one.jpg")
    (tmp_path / "textures" / "index.json").write_text(json.dumps([texture]))
    pack_assets([tmp_path], tmp_path / "pack.zip")
    pack = AssetPack(tmp_path / "pack.zip")
    assert [each.title for each in credit_insertions(job.folder, photos, pack)] == [photos.name]

    # as if the texture were a thing in one of the pictures
    things = next((job.folder / "things").iterdir())
    things.write_text(json.dumps([{"label": "rug", "asset": pack.entries[0].key}]))
    credits = credit_insertions(job.folder, photos, pack)
    assert {each.author for each in credits} == {"Somebody", "not stated"}
    assert read_credits_file(job.folder / "credits.json") == credits
