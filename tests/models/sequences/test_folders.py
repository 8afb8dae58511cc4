"""Sequences in folders: both layouts read as written, and every flaw named."""

import json
import pickle

import numpy as np
import pytest
from PIL import Image

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.sequences.folders import read_sequence_folder
from footprints_edge_models.sequences.layouts import read_sequence
from footprints_edge_models.sequences.sequence import DepthPicture, SequenceError, StereoPair

SIZE = (30, 40)
MATRIX = [[35.0, 0, 19.5], [0, 36.0, 14.5], [0, 0, 1]]


def picture(path, value=90):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.full((*SIZE, 3), value, np.uint8)).save(path)


def moved(x):
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


@pytest.fixture
def clip(tmp_path):
    """Three RGB-D frames; the second comes with labels."""
    folder = tmp_path / "clip"
    for index, name in enumerate(("a", "b", "c")):
        picture(folder / "images" / f"{name}.jpg")
        depth_mm = np.full(SIZE, 1500 + index, np.uint16)
        depth_mm[0] = 0
        (folder / "depth").mkdir(exist_ok=True)
        Image.fromarray(depth_mm).save(folder / "depth" / f"{name}.png")
    ids = np.full(SIZE, 1, np.uint8)
    ids[20:] = 4
    ids[25:] = 29
    (folder / "labels").mkdir()
    Image.fromarray(ids).save(folder / "labels" / "b.png")
    stated = {
        "intrinsics": MATRIX,
        "depth_unit": "millimetre, 0 = none",
        "frames": [
            {"name": name, "camera_to_world": moved(i).tolist()} for i, name in enumerate("abc")
        ],
    }
    (folder / "sequence.json").write_text(json.dumps(stated))
    return folder


def restate(folder, change):
    stated = json.loads((folder / "sequence.json").read_text())
    change(stated)
    (folder / "sequence.json").write_text(json.dumps(stated))


def test_an_rgbd_clip(clip):
    sequence = read_sequence_folder(clip)
    assert sequence.name == "clip"
    assert [frame.name for frame in sequence.frames] == ["a", "b", "c"]
    assert [frame.time for frame in sequence.frames] == [0, 1, 2]
    assert sequence.up == (0, 1, 0)
    for index, frame in enumerate(sequence.frames):
        assert frame.intrinsics == Intrinsics(35.0, 36.0, 19.5, 14.5)
        np.testing.assert_array_equal(frame.camera_to_world, moved(index))
        depth_m = frame.depth.read()
        assert depth_m.dtype == np.float32
        assert not depth_m[0].any()
        np.testing.assert_allclose(depth_m[1:], 1.5 + index / 1000)
    given = [frame.ground for frame in sequence.frames]
    assert given[0] is given[2] is None
    expected = np.zeros(SIZE)
    expected[20:] = 1
    np.testing.assert_array_equal(given[1].read(), expected)
    assert pickle.loads(pickle.dumps(sequence)).frames[1].ground == given[1]


def test_gravity_points_away_from_up_even_where_it_is_text(clip):
    restate(clip, lambda stated: stated.update(gravity_direction=["-0.1", "0.9", "0.4"]))
    assert read_sequence_folder(clip).up == (0.1, -0.9, -0.4)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda s: s.pop("frames"), "'frames' is missing"),
        (lambda s: s.update(intrinsics=[[1, 0, 0], [0, 1, 0]]), "3x3"),
        (lambda s: s.update(intrinsics=[[0, 0, 9], [0, 9, 9], [0, 0, 1]]), "fx is 0"),
        (lambda s: s.update(depth_unit="inch"), "depth_unit 'inch'"),
        (lambda s: s.update(gravity_direction=[0, 0, 0]), "gravity_direction"),
        (lambda s: s["frames"][1].pop("camera_to_world"), "frame b has no pose"),
        (lambda s: s["frames"][1].pop("name"), "frame number 1 has no name"),
        (lambda s: s["frames"][1].update(name="../b"), "leaves the folder"),
        (lambda s: s["frames"][1].update(name="a"), "more than once"),
        (lambda s: s["frames"][1].update(name="d"), "no picture named d"),
        (lambda s: s["frames"][1].update(camera_to_world=[[1, 0], [0, 1]]), "3x4 or 4x4"),
        (lambda s: s["frames"][1].update(camera_to_world="lost"), "frame b"),
        (
            lambda s: s["frames"][1].update(camera_to_world=np.full((4, 4), np.nan).tolist()),
            "frame b.*not finite",
        ),
        (
            lambda s: s["frames"][1].update(camera_to_world=np.diag([2.0, 2, 2, 1]).tolist()),
            "frame b.*not rigid",
        ),
        (
            lambda s: s["frames"][1].update(camera_to_world=np.diag([1.0, 1, -1, 1]).tolist()),
            "frame b.*not rigid",
        ),
    ],
)
def test_flaws_of_sequence_json_are_named(clip, change, says):
    restate(clip, change)
    with pytest.raises(SequenceError, match=says):
        read_sequence_folder(clip)


@pytest.mark.parametrize("lost", ["images/b.jpg", "depth/b.png"])
def test_missing_files_are_named(clip, lost):
    (clip / lost).unlink()
    with pytest.raises(SequenceError, match=r"(images|depth).*b"):
        read_sequence_folder(clip)


def test_broken_json_and_no_sequence_at_all(clip, tmp_path):
    (clip / "sequence.json").write_text("{")
    with pytest.raises(SequenceError, match="JSON"):
        read_sequence_folder(clip)
    for reader in (read_sequence_folder, read_sequence):
        with pytest.raises(SequenceError, match=r"sequence\.json"):
            reader(tmp_path)


@pytest.mark.parametrize("text", ["[" * 100_000, '{"a": ' * 100_000], ids=["lists", "maps"])
def test_deeply_nested_json_is_named(clip, text):
    (clip / "sequence.json").write_text(text)
    with pytest.raises(SequenceError, match="not readable as JSON"):
        read_sequence(clip)


@pytest.mark.parametrize("key", ["intrinsics", "gravity_direction", "camera_to_world"])
def test_integers_without_end_are_named(clip, key):
    rows = {"intrinsics": 3, "gravity_direction": 0, "camera_to_world": 4}[key]
    numbers = [[10**400] * rows] * rows if rows else [10**400, 0, 0]
    restate(
        clip,
        lambda s: (s["frames"][0] if key == "camera_to_world" else s).update({key: numbers}),
    )
    with pytest.raises(SequenceError) as caught:
        read_sequence(clip)
    assert len(str(caught.value)) < 600


def test_a_damaged_depth_picture_shows_when_it_is_read(clip):
    (clip / "depth" / "b.png").write_bytes(b"nothing")
    frames = read_sequence_folder(clip).frames
    frames[0].depth.read()
    with pytest.raises(SequenceError, match=r"b\.png"):
        frames[1].depth.read()


@pytest.fixture
def pairs(tmp_path):
    """Two stereo pairs; the second camera stands half a metre to the right."""
    folder = tmp_path / "pairs"
    for side in ("image_l", "image_r"):
        for name in ("000000.png", "000001.png"):
            picture(folder / side / name)
    left = [35.0, 0, 19.5, 0, 0, 36.0, 14.5, 0, 0, 0, 1, 0]
    right = [35.0, 0, 19.5, -17.5, 0, 36.0, 14.5, 0, 0, 0, 1, 0]
    np.savetxt(folder / "calib.txt", [left, right])
    np.savetxt(folder / "poses.txt", [moved(x)[:3].ravel() for x in (0, 0.3)])
    return folder


def test_a_stereo_clip(pairs):
    sequence = read_sequence(pairs)
    first, second = sequence.frames
    assert first.depth == StereoPair(
        pairs / "image_l" / "000000.png", pairs / "image_r" / "000000.png", 35.0 * 0.5
    )
    assert second.intrinsics == Intrinsics(35.0, 36.0, 19.5, 14.5)
    np.testing.assert_allclose(second.camera_to_world, moved(0.3))
    assert sequence.up == (0, -1, 0)


def test_flaws_of_a_stereo_clip_are_named(pairs):
    poses = (pairs / "poses.txt").read_text()
    (pairs / "poses.txt").write_text(poses.splitlines()[0])
    with pytest.raises(SequenceError, match="1 poses for 2 pictures"):
        read_sequence_folder(pairs)
    (pairs / "poses.txt").write_text(poses)
    (pairs / "image_r" / "000001.png").unlink()
    with pytest.raises(SequenceError, match="image_r: no picture named 000001"):
        read_sequence_folder(pairs)
    np.savetxt(pairs / "calib.txt", np.eye(3))
    with pytest.raises(SequenceError, match="24 numbers"):
        read_sequence_folder(pairs)
    (pairs / "calib.txt").unlink()
    with pytest.raises(SequenceError, match=r"calib\.txt"):
        read_sequence_folder(pairs)


def test_the_data_of_this_project_reads(shared):
    for name, count, kind in (
        ("hololens_office", 300, DepthPicture),
        ("seven_scenes_kitchen", 200, DepthPicture),
        ("kitti_grey_stereo", 51, StereoPair),
    ):
        folder = shared / "data" / name
        if not folder.is_dir():
            pytest.skip(f"no {name} beside this checkout")
        sequence = read_sequence(folder)
        assert len(sequence.frames) == count
        assert isinstance(sequence.frames[0].depth, kind)
        assert all(frame.image.is_file() for frame in sequence.frames)
