"""Folders of views: what training and the benchmark read from them."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from footprints_edge_bench.ground_truth.datasets import ReadingOptions, Subset, open_folder
from footprints_edge_models.cli import app
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.mixture import load_datasets
from footprints_edge_models.panoramas.labels import PanoramaError
from footprints_edge_models.panoramas.make import make_views
from footprints_edge_models.sample import FOOTPRINT, NO, UNKNOWN, YES


@pytest.fixture
def data(write_panoramas, tmp_path):
    """A folder of data with four views of each of two panoramas, one of them held out."""
    make_views(write_panoramas("meadow", "lobby").parent, tmp_path / "panoramas", 4, 0, lambda: 0)
    return tmp_path


def test_training_reads_them_and_holds_panoramas_out_by_name(data):
    (dataset,) = load_datasets(data).values()
    assert [sample.name for sample in dataset.train] == [
        f"panoramas/meadow_00{number}" for number in range(4)
    ]
    assert {sample.name[:-4] for sample in dataset.held_out} == {"panoramas/lobby"}
    found = set()
    for sample in (*dataset.train, *dataset.held_out):
        assert sample.image.shape[:2] == sample.ground.shape
        assert sample.visible_depth_m is None
        assert sample.ground_depth_m is None
        assert (sample.ground[sample.visible_ground == YES] == YES).all()
        unknown = sample.ground == UNKNOWN
        np.testing.assert_array_equal(unknown, sample.visible_ground == UNKNOWN)
        found |= set(np.unique(sample.ground))
    assert found == {NO, YES, FOOTPRINT, UNKNOWN}


def test_the_benchmark_scores_the_same_ones(data):
    (dataset,) = open_folder(
        data / "panoramas", ReadingOptions(), Subset.parse("0:1", held_out=True)
    )
    assert [item.name for item in dataset.items] == [
        f"panoramas/lobby_00{number}" for number in range(4)
    ]
    held_out = load_datasets(data)["panoramas"].held_out
    for item, sample in zip(dataset.items, held_out, strict=True):
        truth = item.load()
        assert truth.intrinsics == sample.intrinsics
        np.testing.assert_array_equal(truth.visible_ground.mask, sample.visible_ground == YES)
        np.testing.assert_array_equal(truth.ground.mask, sample.ground == YES)
        np.testing.assert_array_equal(truth.ground.valid, sample.ground != UNKNOWN)
        np.testing.assert_array_equal(truth.footprints, sample.ground == FOOTPRINT)


def test_credits_are_named(data):
    credits = json.loads((data / "panoramas" / "credits.json").read_text())
    assert [credit["title"] for credit in credits] == ["lobby", "meadow"]
    assert {credit["licence"] for credit in credits} == {"CC0-1.0"}


def test_more_views_keep_those_that_are_there(write_panoramas, tmp_path):
    folder = write_panoramas("meadow")
    for name, count in (("few", 2), ("many", 3)):
        make_views(folder, tmp_path / name, count, 0, lambda: 0)
    for path in sorted((tmp_path / "few").glob("*/*")):
        again = tmp_path / "many" / path.relative_to(tmp_path / "few")
        assert again.read_bytes() == path.read_bytes()


def test_a_folder_that_is_made_anew_is_unfinished_until_the_end(data):
    def stop():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_views(data / "assets", data / "panoramas", 4, 1, stop)
    with pytest.raises(DatasetError, match="fp-train panoramas"):
        load_datasets(data)


def test_a_damaged_panorama_is_named_and_the_others_are_used(write_panoramas, tmp_path):
    folder = write_panoramas("meadow", "broken", "void")
    (folder / "broken.jpg").write_bytes(b"no picture")
    labels = json.loads((folder / "labels" / "void.json").read_text())
    (folder / "labels" / "void.json").write_text(json.dumps(labels | {"ground": []}))
    result = CliRunner().invoke(
        app, ["panoramas", str(folder), "-o", str(tmp_path / "out"), "--views", "2"]
    )
    assert result.exit_code == 1
    assert "broken: not a readable picture" in result.stderr
    summary = json.loads(result.stdout)
    assert (summary["panoramas"], summary["views"], summary["skipped"]) == (1, 2, 1)
    assert (tmp_path / "out" / "contact-sheet.png").is_file()


@pytest.mark.parametrize(
    ("text", "says"),
    [("[]", "no readable polygons"), ('{"width": 9}', "height"), ("{", "no readable polygons")],
)
def test_odd_labels(write_panoramas, tmp_path, text, says):
    folder = write_panoramas("meadow")
    (folder / "labels" / "meadow.json").write_text(text)
    with pytest.raises(PanoramaError, match=says):
        make_views(folder, tmp_path / "out", 1, 0, lambda: 0)


def test_a_folder_without_panoramas(tmp_path):
    with pytest.raises(PanoramaError, match=r"index\.json"):
        make_views(tmp_path, tmp_path / "out", 1, 0, lambda: 0)


def test_an_unfinished_folder_says_what_to_do(data):
    (data / "panoramas" / "panoramas.json").unlink()
    with pytest.raises(DatasetError, match="fp-train panoramas"):
        load_datasets(data)
