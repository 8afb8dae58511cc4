"""Matterport3D and its published training data, on a made-up room with a box in it."""

import numpy as np
import pytest
from PIL import Image

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.data.readers.published_matterport import read_matterport_training
from footprints_edge_models.sample import NO, UNSEEN, YES
from footprints_edge_models.sequences.layouts import read_sequence
from footprints_edge_models.sequences.matterport import read_matterport
from footprints_edge_models.sequences.sequence import InSpace, SequenceError
from footprints_edge_models.video_labels.labeller import Labeller, LabelSettings

SCAN = "2azQ1b91cZZ"
SIZE = (102, 128)
CAMERA = Intrinsics(107.0, 107.5, 63.1, 50.9)
EYES = {"0aa1": (2.5, 0.0, 1.5), "0bb2": (-2.5, 0.1, 1.5)}
BOX = (-0.3, -0.5, 0.0), (0.3, 0.5, 0.8)


@pytest.fixture
def room(scene, box):
    return scene((box(*BOX),))


@pytest.fixture
def raw(tmp_path, room, pose):
    """Two tripod positions on two sides of the box; at each, three heights in one direction."""
    raw = tmp_path / "matterport"
    folder = raw / SCAN / SCAN
    for part in ("color_images", "depth_images", "camera_poses", "camera_intrinsics"):
        (folder / f"matterport_{part}").mkdir(parents=True)
    for pos, eye in EYES.items():
        for height, target in ((0, (0, 0, 3.0)), (1, (0, 0, 0.6)), (2, (eye[0] / 2, 0, 0))):
            at = pose(eye, target)
            depth_m = room.depth_m(at, CAMERA, SIZE)
            units = np.rint(np.where(depth_m < 12, depth_m, 0) * 4000).astype(np.uint16)
            picture = np.full((*SIZE, 3), 60 * height, np.uint8)
            Image.fromarray(picture).save(
                folder / "matterport_color_images" / f"{pos}_i{height}_4.jpg"
            )
            Image.fromarray(units).save(
                folder / "matterport_depth_images" / f"{pos}_d{height}_4.png"
            )
            np.savetxt(folder / "matterport_camera_poses" / f"{pos}_pose_{height}_4.txt", at)
            (folder / "matterport_camera_intrinsics" / f"{pos}_intrinsics_{height}.txt").write_text(
                "128 102 107.0 107.5 63.1 50.9 0.01 0 0 0 0"
            )
    return raw


def floor_m(at):
    """Depth (H, W) of the floor on each ray, 0 where there is none."""
    rows, columns = np.mgrid[: SIZE[0], : SIZE[1]].astype(float)
    x, y = (columns - CAMERA.cx) / CAMERA.fx, (rows - CAMERA.cy) / CAMERA.fy
    fall = (np.stack([x, y, np.ones_like(x)], -1) @ at[:3, :3].T)[..., 2]
    with np.errstate(divide="ignore"):
        return np.where(fall < 0, -at[2, 3] / fall, 0)


@pytest.fixture
def published(tmp_path, raw, room):
    root = tmp_path / "matterport_training_data"
    (root / "ground_seg" / SCAN / "data").mkdir(parents=True)
    for frame in read_matterport(raw, SCAN).frames:
        floor, depth_m = (
            floor_m(frame.camera_to_world),
            room.depth_m(frame.camera_to_world, CAMERA, SIZE),
        )
        seen = (floor > 0) & (np.abs(floor - depth_m) < 1e-3)
        ground = np.where(seen, 0.95, 0.05)[None].astype(np.float32)
        np.save(root / "ground_seg" / SCAN / "data" / f"{frame.name}.npy", ground)
    return root


def test_a_scan(raw, room, pose):
    sequence = read_matterport(raw, SCAN)
    # The cameras that look up see no floor; the paper leaves them out.
    assert [frame.name for frame in sequence.frames] == [
        "0aa1_1_4", "0aa1_2_4", "0bb2_1_4", "0bb2_2_4"
    ]  # fmt: skip
    assert sequence.neighbours == InSpace((10, 10, 1))
    assert sequence.least_hits == 0
    assert sequence.up == (0, 0, 1)
    frame = sequence.frames[0]
    assert frame.intrinsics == CAMERA
    at = pose(EYES["0aa1"], (0, 0, 0.6))
    np.testing.assert_allclose(frame.camera_to_world, at)
    depth_m = room.depth_m(at, CAMERA, SIZE)
    measured = (depth_m > 0) & (depth_m < 12)
    np.testing.assert_allclose(frame.depth.read()[measured], depth_m[measured], atol=1.3e-4)
    for folder in (raw / SCAN, raw / SCAN / SCAN):
        assert read_sequence(folder).name == SCAN


def test_floor_behind_the_box_is_labelled_from_the_other_side(raw, published):
    sequence = read_matterport(raw, SCAN, published)
    frame = sequence.frames[0]
    labels = Labeller(sequence, LabelSettings()).label(0)
    floor = floor_m(frame.camera_to_world)
    hidden = (labels.ground_depth_m > 0) & (labels.ground_probability < 0.5)
    assert hidden.sum() > 100
    assert (labels.visible_depth_m[hidden] < floor[hidden]).all()
    labelled = labels.ground_depth_m > 0
    # Half a pixel of rounding, times how fast the floor's depth changes from row to row.
    steep = np.abs(np.gradient(floor, axis=0)) / np.maximum(floor, 1e-9)
    off = np.abs(labels.ground_depth_m / np.maximum(floor, 1e-9) - 1)
    assert (off[labelled] < 0.6 * steep[labelled] + 1e-3).mean() > 0.99


@pytest.mark.parametrize(
    "lost",
    [
        "matterport_camera_poses/0bb2_pose_1_4.txt",
        "matterport_camera_intrinsics/0bb2_intrinsics_1.txt",
    ],
)
def test_missing_files_are_named(raw, lost):
    (raw / SCAN / SCAN / lost).unlink()
    with pytest.raises(SequenceError, match=lost.split("/")[1]):
        read_matterport(raw, SCAN)


def test_a_scan_that_is_not_there(tmp_path):
    with pytest.raises(SequenceError, match="matterport_color_images"):
        read_matterport(tmp_path, SCAN)


def test_published_labels_as_samples(raw, published):
    hidden_m, mask = np.full(SIZE, 0.1, np.float32), np.zeros(SIZE, np.uint8)
    hidden_m[60:70, 40:60] = 4.0
    hidden_m[60:70, 60:70] = 12.0
    mask[62:64, 42:44] = 1
    for kind, values in (("hidden_depth", hidden_m), ("depth_masks", mask)):
        (published / kind / SCAN / "data").mkdir(parents=True)
        np.save(published / kind / SCAN / "data" / "0aa1_1_4.npy", values)
    (sample,) = read_matterport_training(raw, published, [f"{SCAN} 0aa1 1 4\n", "\n"])
    assert sample.name == f"{SCAN}/0aa1_1_4"
    assert sample.image.mean() == pytest.approx(60, abs=2)
    assert sample.intrinsics == CAMERA
    assert sample.moving is None
    seen = sample.visible_ground == YES
    expected = np.full(SIZE, UNSEEN)
    expected[60:70, 40:60] = YES
    expected[seen] = YES
    expected[62:64, 42:44] = NO
    np.testing.assert_array_equal(sample.ground, expected)
    inside = np.zeros(SIZE, bool)
    inside[60:70, 40:60] = True
    assert set(np.unique(sample.ground_depth_m[inside])) == {0, 4}
    # Ground that is seen is as far away as the sensor says; what is 12 m away was not told.
    np.testing.assert_array_equal(
        sample.ground_depth_m[seen & ~inside], sample.visible_depth_m[seen & ~inside]
    )


def test_lines_that_are_no_split_are_named(raw, published):
    with pytest.raises(SequenceError, match="is not 'scan pos height direction'"):
        list(read_matterport_training(raw, published, [f"{SCAN} 0aa1 1"]))
