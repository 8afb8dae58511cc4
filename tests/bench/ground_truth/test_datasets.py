"""Opening datasets, and parts of them."""

import json
import math

import pytest
from PIL import Image

from footprints_edge_bench.ground_truth.base import EvaluationDataset, GroundTruthError
from footprints_edge_bench.ground_truth.datasets import (
    ReadingOptions,
    Subset,
    open_datasets,
    open_folder,
)
from footprints_edge_models.data.mixture import load_datasets

ALL = Subset()


@pytest.mark.parametrize("kind", ["kitti", "matterport"])
def test_ground_truth_without_images_says_what_to_give(kind, kitti, matterport):
    folder = kitti if kind == "kitti" else matterport[0]
    with pytest.raises(GroundTruthError, match="--images"):
        open_folder(folder, ReadingOptions(), ALL)


def test_a_folder_of_something_else_is_refused(tmp_path):
    with pytest.raises(GroundTruthError, match=r"sequence\.json"):
        open_folder(tmp_path, ReadingOptions(), ALL)
    with pytest.raises(GroundTruthError, match="absent"):
        open_folder(tmp_path / "absent", ReadingOptions(), ALL)


def test_folders_of_one_name_are_refused(clip, tmp_path):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "walk").symlink_to(clip)
    with pytest.raises(GroundTruthError, match="walk"):
        open_datasets([clip, clip], ReadingOptions(), ALL)


@pytest.mark.parametrize(
    ("text", "every", "expected"),
    [
        ("0:1", 1, range(10)),
        ("0.8:1", 1, [8, 9]),
        ("0.8:", 1, [8, 9]),
        (":0.5", 2, [0, 2, 4]),
        ("0.1:0.4", 1, [1, 2, 3]),
    ],
)
def test_a_part_is_a_share_of_the_images(clip, text, every, expected):
    (dataset,) = open_folder(clip, ReadingOptions(), Subset.parse(text, every))
    assert [item.name for item in dataset.items] == [f"walk/f{i}" for i in expected]


def test_the_parts_of_a_clip_share_no_frame(clip):
    for cut in (0.1, 0.33, 0.7, 0.8, 0.9):
        parts = [
            open_folder(clip, ReadingOptions(), Subset.parse(t))[0]
            for t in (f"0:{cut}", f"{cut}:1")
        ]
        names = [item.name for part in parts for item in part.items]
        assert names == [f"walk/f{i}" for i in range(10)], cut


@pytest.mark.parametrize("text", ["", "0.8", "1:0", "a:b", "0:2", "-1:1", "0.5:0.5"])
def test_a_part_that_is_none_is_refused(text):
    with pytest.raises(GroundTruthError, match=r"0\.8:1"):
        Subset.parse(text)


def test_a_part_without_images_is_refused(clip):
    with pytest.raises(GroundTruthError, match="no image"):
        open_folder(clip, ReadingOptions(), Subset.parse("0:0.01"))


@pytest.mark.parametrize("name", ["hololens_office", "seven_scenes_kitchen"])
def test_the_shared_clips_are_recognised(shared, name):
    (dataset,) = open_folder(shared / "data" / name, ReadingOptions(), Subset.parse("0.8:1"))
    assert isinstance(dataset, EvaluationDataset)
    total = len(json.loads((shared / "data" / name / "sequence.json").read_text())["frames"])
    assert len(dataset.items) == math.ceil(total / 5)


def test_held_out_photos_are_those_that_training_holds_out(tmp_path):
    folder = tmp_path / "idd_lite"
    for part in ("images", "labels"):
        (folder / part).mkdir(parents=True)
    for drive in range(12):
        for frame in range(3):
            name = f"{drive}_{frame}"
            Image.new("RGB", (64, 32)).save(folder / "images" / f"{name}.jpg")
            Image.new("L", (64, 32)).save(folder / "labels" / f"{name}.png")
    photos = ReadingOptions(walkable=(0,))
    part = Subset.parse("0:1", held_out=True)
    found = {item.name for item in open_folder(folder, photos, part)[0].items}
    trained_on = load_datasets(tmp_path)["idd_lite"].train
    names = {item.name for item in open_folder(folder, photos, ALL)[0].items}
    assert found == names - {sample.name for sample in trained_on}
    assert 0 < len(found) < len(names)
    unknown = folder.rename(tmp_path / "photos")
    assert len(open_folder(unknown, photos, part)[0].items) == len(names)
