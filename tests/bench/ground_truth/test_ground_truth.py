"""Readers of ground truth, on made-up trees of the layouts that are published."""

import json
import math

import numpy as np
import pytest
from PIL import Image

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_bench.geometry.convex_hull import convex_hull
from footprints_edge_bench.ground_truth.base import EvaluationDataset, GroundTruthError
from footprints_edge_bench.ground_truth.datasets import (
    ReadingOptions,
    Subset,
    open_dataset,
    open_datasets,
)
from footprints_edge_models.data.datasets import load_datasets

SIZE = (120, 160)
ALL = Subset()


def save_mask(path, mask):
    Image.fromarray(np.where(mask, np.uint8(255), np.uint8(0))).save(path)


def save_picture(path, size=SIZE):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.full((*size, 3), 90, np.uint8)).save(path)


def loaded(dataset):
    return {item.name: item.load() for item in dataset.items}


@pytest.fixture
def kitti(tmp_path):
    """Two annotated images: a polygon of ground and the footprint of a thing within it."""
    folder = tmp_path / "annotations"
    folder.mkdir()
    for number in ("00000", "00001"):
        ground, thing = np.zeros(SIZE, bool), np.zeros(SIZE, bool)
        ground[60:], thing[80:90, 50:70] = True, True
        save_mask(folder / f"{number}_ground.png", ground)
        save_mask(folder / f"{number}_objects.png", thing)
        save_mask(folder / f"{number}_combined.png", ground & ~thing)
    return folder


def test_kitti_truth_is_the_polygon_without_the_footprints(kitti, tmp_path):
    for number in ("00000", "00001"):
        save_picture(tmp_path / "pictures" / f"{number}.png")
    dataset = open_dataset(kitti, ReadingOptions(images=tmp_path / "pictures"), ALL)
    assert dataset.kind == "KITTI"
    ground_truths = loaded(dataset)
    assert list(ground_truths) == ["annotations/00000", "annotations/00001"]
    ground_truth = ground_truths["annotations/00001"]
    assert ground_truth.image == tmp_path / "pictures" / "00001.png"
    rows, columns = np.mgrid[: SIZE[0], : SIZE[1]]
    thing = (rows >= 80) & (rows < 90) & (columns >= 50) & (columns < 70)
    np.testing.assert_array_equal(ground_truth.ground.mask, (rows >= 60) & ~thing)
    np.testing.assert_array_equal(ground_truth.region, rows >= 60)
    assert ground_truth.ground.valid.all()
    assert ground_truth.visible_ground is None and ground_truth.ground_depth_m is None
    # as the published training has KITTI's cameras
    assert ground_truth.intrinsics.fx == pytest.approx(0.58 * 160)
    assert ground_truth.intrinsics.fy == pytest.approx(1.92 * 120)


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        (["a/first.jpg", "a/second.jpg"], "a/second.jpg"),
        (["d1 3 l", "d1/sync 0000000069 r"], "d1/sync/image_03/data/0000000069.jpg"),
        (["d1 3 l", "d1/sync 12 l"], "d1/sync/image_02/data/0000000012.jpg"),
    ],
    ids=["paths", "right", "left"],
)
def test_kitti_pictures_come_in_the_order_of_the_split(kitti, tmp_path, lines, expected):
    raw = tmp_path / "raw"
    save_picture(raw / expected)
    split = raw / "test_files.txt"
    split.write_text("\n".join(lines) + "\n")
    dataset = open_dataset(kitti, ReadingOptions(images=split), ALL)
    assert dataset.items[1].load().image == raw / expected


def test_a_split_that_is_too_short_is_said_so(kitti, tmp_path):
    split = tmp_path / "split.txt"
    split.write_text("one.jpg\n")
    dataset = open_dataset(kitti, ReadingOptions(images=split), ALL)
    with pytest.raises(GroundTruthError, match="lists 1 pictures"):
        dataset.items[1].load()


@pytest.fixture
def matterport(tmp_path):
    """One test image with its raw data: floor at 2 m, a thing hides some of it at 1 m."""
    folder, raw = tmp_path / "truth", tmp_path / "raw" / "scan1" / "scan1"
    folder.mkdir()
    ground_m = np.zeros((64, 80), np.float32)
    ground_m[32:] = 2.0
    region = np.zeros((64, 80), np.float32)
    region[40:] = 1.0
    np.save(folder / "scan1_abc_1_4_groundtruth.npy", ground_m)
    np.save(folder / "scan1_abc_1_4_freespace.npy", region)
    save_picture(raw / "matterport_color_images" / "abc_i1_4.jpg", (128, 160))
    cameras = raw / "matterport_camera_intrinsics"
    cameras.mkdir()
    (cameras / "abc_intrinsics_1.txt").write_text("160 128 150.5 151.5 80.5 62.5 0 0 0 0 0\n")
    return folder, raw


def test_matterport_truth_is_what_the_files_say(matterport, tmp_path):
    folder, raw = matterport
    dataset = open_dataset(folder, ReadingOptions(images=tmp_path / "raw"), ALL)
    assert dataset.kind == "Matterport"
    ((name, ground_truth),) = loaded(dataset).items()
    assert name == "truth/scan1_abc_1_4"
    assert ground_truth.image == raw / "matterport_color_images" / "abc_i1_4.jpg"
    assert ground_truth.intrinsics == Intrinsics(150.5, 151.5, 80.5, 62.5)
    rows = np.mgrid[:64, :80][0]
    np.testing.assert_array_equal(ground_truth.ground.mask, rows >= 32)
    np.testing.assert_array_equal(ground_truth.ground_depth_m, np.where(rows >= 32, 2, 0))
    np.testing.assert_array_equal(ground_truth.region, rows >= 40)
    assert ground_truth.visible_ground is None and ground_truth.visible_depth_m is None


def test_matterport_s_measured_depth_shows_what_is_visible(matterport, tmp_path):
    folder, raw = matterport
    depth_m = np.full((128, 160), 2.0)
    depth_m[:, :80] = 1.0  # in front of the floor
    depth_m[:, 150:] = 0  # not measured
    (raw / "matterport_depth_images").mkdir()
    units = (depth_m / 0.00025).astype(np.uint16)
    Image.fromarray(units).save(raw / "matterport_depth_images" / "abc_d1_4.png")
    (ground_truth,) = loaded(
        open_dataset(folder, ReadingOptions(images=tmp_path / "raw"), ALL)
    ).values()
    rows, columns = np.mgrid[:64, :80]
    expected = (rows >= 32) & (columns >= 40) & (columns < 75)
    np.testing.assert_array_equal(ground_truth.visible_ground.mask, expected)
    np.testing.assert_array_equal(ground_truth.visible_ground.valid, columns < 75)
    np.testing.assert_allclose(ground_truth.visible_depth_m[0], np.repeat([1, 2, 0], [40, 35, 5]))


@pytest.fixture
def clip(tmp_path, camera, pose, floor_of):
    """Ten frames of a floor with a crate, from left and right; the world's z points up."""
    folder = tmp_path / "walk"
    (folder / "images").mkdir(parents=True)
    (folder / "depth").mkdir()
    low, high = np.array([-0.3, 1.7, 0]), np.array([0.3, 2.1, 0.4])
    frames = []
    for i, x in enumerate(np.linspace(-1.0, 1.0, 10)):
        view = pose(down_deg=35, x=x)
        points, floor_m = floor_of(view)
        directions = (points - view[:3, 3]) / np.where(floor_m > 0, floor_m, 1)[..., None]
        with np.errstate(divide="ignore"):
            first, second = (low - view[:3, 3]) / directions, (high - view[:3, 3]) / directions
        enter = np.minimum(first, second).max(-1)
        hit = (enter < np.maximum(first, second).min(-1)) & (floor_m > 0)
        depth_m = np.where(hit, enter, np.where(floor_m < 6, floor_m, 0))
        depth_mm = Image.fromarray(np.rint(1000 * depth_m).astype(np.uint16))
        depth_mm.save(folder / "depth" / f"f{i}.png")
        save_picture(folder / "images" / f"f{i}.jpg")
        frames.append({"name": f"f{i}", "camera_to_world": view.tolist()})
    K = [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]]
    (folder / "sequence.json").write_text(
        json.dumps({"intrinsics": K, "gravity_direction": [0, 0, -1], "frames": frames})
    )
    return folder


def test_a_clip_s_truth_is_what_the_whole_clip_saw(clip, camera, pose, floor_of):
    dataset = open_dataset(clip, ReadingOptions(), ALL)
    assert dataset.kind == "clip"
    ground_truths = loaded(dataset)
    assert list(ground_truths) == [f"walk/f{i}" for i in range(10)]
    ground_truth = ground_truths["walk/f0"]
    assert ground_truth.image == clip / "images" / "f0.jpg"
    assert ground_truth.intrinsics == camera
    points, floor_m = floor_of(pose(down_deg=35, x=-1.0))
    x, y = points[..., 0], points[..., 1]

    def crate(margin_m):
        return (np.abs(x) < 0.3 + margin_m) & (np.abs(y - 1.9) < 0.2 + margin_m)

    inside, around = crate(-0.06), crate(0.5) & ~crate(0.1)
    assert ground_truth.ground.valid[inside].mean() > 0.95
    assert not ground_truth.ground.mask[inside].any()
    valid = ground_truth.ground.valid
    assert ground_truth.ground.mask[around & valid].mean() > 0.99
    assert valid[around & (y < 2.1)].mean() > 0.99
    hidden = around & valid & (ground_truth.visible_depth_m < floor_m - 0.1)
    assert hidden.sum() > 30  # this frame does not see it, others do
    assert not ground_truth.visible_ground.mask[hidden].any()
    known_m = ground_truth.ground_depth_m[ground_truth.ground.mask]
    np.testing.assert_allclose(known_m, floor_m[ground_truth.ground.mask], rtol=1e-3)
    assert (ground_truth.ground_depth_m[~ground_truth.ground.mask] == 0).all()
    # far away nobody saw anything; above the horizon is no ground
    assert not ground_truth.ground.valid[(floor_m > 12)].any()
    above = floor_m == 0
    assert ground_truth.ground.valid[above].all() and not ground_truth.ground.mask[above].any()
    np.testing.assert_array_equal(
        ground_truth.region, convex_hull(ground_truth.visible_ground.mask)
    )


def test_labelled_photos_say_what_is_visible(tmp_path):
    folder = tmp_path / "photos"
    save_picture(folder / "images" / "a.jpg")
    (folder / "labels").mkdir()
    ids = np.full(SIZE, 7, np.uint8)
    ids[40:, :50], ids[40:, 50:90], ids[40:, 90:] = 3, 4, 11
    Image.fromarray(ids).save(folder / "labels" / "a.png")
    dataset = open_dataset(folder, ReadingOptions(walkable=(3, 4), void=(11,)), ALL)
    ground_truth = dataset.items[0].load()
    np.testing.assert_array_equal(ground_truth.visible_ground.mask, (ids == 3) | (ids == 4))
    np.testing.assert_array_equal(ground_truth.visible_ground.valid, ids != 11)
    assert ground_truth.ground is None and ground_truth.region is None
    with pytest.raises(GroundTruthError, match="--walkable"):
        open_dataset(folder, ReadingOptions(), ALL)


@pytest.mark.parametrize("kind", ["kitti", "matterport"])
def test_truth_without_pictures_says_what_to_give(kind, kitti, matterport):
    folder = kitti if kind == "kitti" else matterport[0]
    with pytest.raises(GroundTruthError, match="--images"):
        open_dataset(folder, ReadingOptions(), ALL)


def test_a_folder_of_something_else_is_refused(tmp_path):
    with pytest.raises(GroundTruthError, match=r"sequence\.json"):
        open_dataset(tmp_path, ReadingOptions(), ALL)
    with pytest.raises(GroundTruthError, match="absent"):
        open_dataset(tmp_path / "absent", ReadingOptions(), ALL)


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
    dataset = open_dataset(clip, ReadingOptions(), Subset.parse(text, every))
    assert [item.name for item in dataset.items] == [f"walk/f{i}" for i in expected]


def test_the_parts_of_a_clip_share_no_frame(clip):
    for cut in (0.1, 0.33, 0.7, 0.8, 0.9):
        parts = [
            open_dataset(clip, ReadingOptions(), Subset.parse(t)) for t in (f"0:{cut}", f"{cut}:1")
        ]
        names = [item.name for part in parts for item in part.items]
        assert names == [f"walk/f{i}" for i in range(10)], cut


@pytest.mark.parametrize("text", ["", "0.8", "1:0", "a:b", "0:2", "-1:1", "0.5:0.5"])
def test_a_part_that_is_none_is_refused(text):
    with pytest.raises(GroundTruthError, match=r"0\.8:1"):
        Subset.parse(text)


def test_a_part_without_images_is_refused(clip):
    with pytest.raises(GroundTruthError, match="no image"):
        open_dataset(clip, ReadingOptions(), Subset.parse("0:0.01"))


@pytest.mark.parametrize("name", ["hololens_office", "seven_scenes_kitchen"])
def test_the_shared_clips_are_recognised(shared, name):
    dataset = open_dataset(shared / "data" / name, ReadingOptions(), Subset.parse("0.8:1"))
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
    found = {item.name for item in open_dataset(folder, photos, part).items}
    trained_on = load_datasets(tmp_path)["idd_lite"].train
    names = {item.name for item in open_dataset(folder, photos, ALL).items}
    assert found == names - {sample.name for sample in trained_on}
    assert 0 < len(found) < len(names)
    unknown = folder.rename(tmp_path / "photos")
    assert len(open_dataset(unknown, photos, part).items) == len(names)
