import io
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from footprints_edge.errors import OutputError
from footprints_edge.outputs import writers
from footprints_edge.outputs.writers import FORMATS

ALL = [name for name in FORMATS if not name.startswith("topdown")]  # these need ground


@pytest.fixture
def saved(tiny, picture, tmp_path):
    """A prediction and the folder that holds all its files."""
    prediction = tiny.predict(picture)
    prediction.save(tmp_path, ALL, name="a.jpg")
    return prediction, tmp_path


def test_the_files_and_their_order(tiny, picture, tmp_path):
    paths = tiny.predict(picture).save(tmp_path / "new" / "folder", ALL, name="a.jpg")
    suffixes = (
        "overlay.png npz visible_depth_mm.png ground_depth_mm.png visible_ground.png ground.png "
        "hidden_ground.png json ply"
    )
    assert [path.name for path in paths] == [f"a.jpg.{suffix}" for suffix in suffixes.split()]
    assert sorted(paths) == sorted((tmp_path / "new" / "folder").iterdir())


def test_npz_holds_the_prediction(saved):
    prediction, folder = saved
    with np.load(folder / "a.jpg.npz") as arrays:
        for name in set(arrays) - {"image_size", "intrinsics", "confidence"}:
            expected = getattr(prediction, name)
            np.testing.assert_array_equal(arrays[name], expected)
            assert arrays[name].dtype == expected.dtype
        assert len(set(arrays)) == 10
        assert tuple(arrays["image_size"]) == (60, 100)
        confidence = prediction.confidence
        np.testing.assert_array_equal(arrays["confidence"], [confidence.ground, confidence.metres])
        camera = prediction.intrinsics
        np.testing.assert_array_equal(
            arrays["intrinsics"], [camera.fx, camera.fy, camera.cx, camera.cy]
        )


def test_png16_is_millimetres_and_masks(saved):
    prediction, folder = saved
    for name in ("visible_depth", "ground_depth"):
        with Image.open(folder / f"a.jpg.{name}_mm.png") as image:
            assert image.mode == "I;16"
            millimetres = np.asarray(image)
        depth_m = getattr(prediction, f"{name}_m")
        known = np.isfinite(depth_m)
        np.testing.assert_array_equal(millimetres[~known], 0)
        np.testing.assert_allclose(
            millimetres[known], np.minimum(1000 * depth_m[known], 65535), atol=0.51
        )
    for name in ("visible_ground", "ground", "hidden_ground"):
        mask = np.asarray(Image.open(folder / f"a.jpg.{name}.png"))
        np.testing.assert_array_equal(mask, 255 * getattr(prediction, name))


def test_json_states_the_facts(saved):
    prediction, folder = saved
    facts = json.loads((folder / "a.jpg.json").read_text())
    assert facts["image_size_px"] == [60, 100]
    assert facts["map_size_px"] == list(prediction.ground.shape)
    fractions = facts["ground_fraction"]
    assert fractions["all"] == pytest.approx(prediction.ground.mean())
    assert fractions["hidden"] == pytest.approx(prediction.hidden_ground.mean())
    distances = facts["ground_distance_m"]
    assert distances["nearest"] == pytest.approx(np.nanmin(prediction.ground_depth_m))
    assert distances["farthest"] == pytest.approx(np.nanmax(prediction.ground_depth_m))
    assert facts["camera"]["source"] == "assumed"
    assert facts["camera"]["hfov_deg"] == pytest.approx(60)
    assert facts["camera"]["focal_length_px"] == pytest.approx(50 / np.tan(np.radians(30)))
    assert facts["model"]["sha256"] == prediction.model.sha256
    assert set(facts["timings_ms"]) == {"decode", "preprocess", "inference", "postprocess"}


def read_ply(path):
    header, body = path.read_bytes().split(b"end_header\n", 1)
    lines = header.decode("ascii").splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"]
    types = {"float": "<f4", "uchar": "u1"}
    fields = [line.split()[1:] for line in lines if line.startswith("property")]
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    points = np.frombuffer(body, [(name, types[kind]) for kind, name in fields])
    assert len(points) == count
    return points


def test_ply_holds_visible_surfaces_and_hidden_ground(saved):
    prediction, folder = saved
    points = read_ply(folder / "a.jpg.ply")
    seen, hidden = points[points["layer"] == 0], points[points["layer"] == 1]
    np.testing.assert_array_equal(seen["z"], prediction.visible_depth_m.ravel())
    np.testing.assert_array_equal(
        hidden["z"], prediction.unmasked_ground_depth_m[prediction.hidden_ground]
    )
    camera = prediction.intrinsics
    rows, columns = np.nonzero(prediction.hidden_ground)
    np.testing.assert_allclose(
        camera.fx * hidden["x"] / hidden["z"] + camera.cx, columns, atol=0.01
    )
    np.testing.assert_allclose(camera.fy * hidden["y"] / hidden["z"] + camera.cy, rows, atol=0.01)
    assert set(zip(hidden["red"], hidden["green"], hidden["blue"], strict=True)) == {(255, 0, 200)}
    assert seen["green"].reshape(prediction.ground.shape)[150, 20] > 200


def test_pictures_without_ground_get_every_format(tiny, tmp_path):
    prediction = tiny.predict(np.zeros((40, 60, 3), np.uint8))
    assert not prediction.ground.any()
    prediction.save(tmp_path, ALL)
    facts = json.loads((tmp_path / "image.json").read_text())
    assert facts["ground_fraction"] == {"visible": 0, "hidden": 0, "all": 0}
    assert facts["ground_distance_m"] == {"nearest": None, "farthest": None}
    assert not np.asarray(Image.open(tmp_path / "image.ground_depth_mm.png")).any()
    assert (read_ply(tmp_path / "image.ply")["layer"] == 0).all()


def test_a_and_a_do_not_collide(tiny, picture, tmp_path):
    for name in ("a.png", "a.bmp"):
        Image.fromarray(picture).save(tmp_path / name)
        tiny.predict(tmp_path / name).save(tmp_path, ALL)
    assert len(list(tmp_path.iterdir())) == 2 + 2 * 9


def test_existing_files_are_kept_and_nothing_else_is_written(saved):
    prediction, folder = saved
    (folder / "a.jpg.ply").unlink()
    (folder / "a.jpg.json").write_text("mine")
    with pytest.raises(
        OutputError, match=r"existing results: .*a\.jpg\.json; nothing.*overwrite=True"
    ):
        prediction.save(folder, ["ply", "json"], name="a.jpg")
    assert (folder / "a.jpg.json").read_text() == "mine"
    assert not (folder / "a.jpg.ply").exists()
    prediction.save(folder, ["ply", "json"], name="a.jpg", overwrite=True)
    assert json.loads((folder / "a.jpg.json").read_text())


def test_the_input_is_never_overwritten(tiny, picture, tmp_path):
    path = tmp_path / "a.overlay.png"
    Image.fromarray(picture).save(path)
    before = path.read_bytes()
    with pytest.raises(OutputError, match="input picture"):
        tiny.predict(path).save(tmp_path / ".", name="a", overwrite=True)
    assert path.read_bytes() == before


@pytest.mark.parametrize("moment", ["write_bytes", "replace"])
def test_a_failing_write_leaves_the_old_file_and_no_other(saved, moment, monkeypatch):
    prediction, folder = saved
    before = {path: path.read_bytes() for path in folder.iterdir()}
    original = Path.write_bytes

    def disk_full(self, _):
        if moment == "write_bytes":
            original(self, b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, moment, disk_full)
    with pytest.raises(OutputError, match="No space left"):
        prediction.save(folder, ["npz"], name="a.jpg", overwrite=True)
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_a_folder_that_can_have_no_name_is_explained(tiny, picture):
    with pytest.raises(OutputError, match="cannot write"):
        tiny.predict(picture).save("a\0b", ["json"], name="t")


def test_a_file_in_place_of_the_folder_is_explained(tiny, picture, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot write"):
        tiny.predict(picture).save(tmp_path / "file", ["json"])


@pytest.mark.parametrize("formats", [["gif"], [], ["npz", "gif"]])
def test_unknown_formats_are_refused_with_the_known_ones(tiny, picture, tmp_path, formats):
    with pytest.raises(OutputError, match="choose from overlay, npz, png16, json, ply"):
        tiny.predict(picture).save(tmp_path, formats)
    assert not list(tmp_path.iterdir())


def test_a_name_must_not_be_a_path(tiny, picture, tmp_path):
    with pytest.raises(OutputError, match="is a path"):
        tiny.predict(picture).save(tmp_path, ["json"], name="../a")


def test_depths_beyond_the_scale_and_too_near_for_it():
    depth_m = np.float32([[np.nan, 0.0001, 1.2344, 70]])
    png = writers._depth_png(depth_m)
    np.testing.assert_array_equal(np.asarray(Image.open(io.BytesIO(png))), [[0, 1, 1234, 65535]])
