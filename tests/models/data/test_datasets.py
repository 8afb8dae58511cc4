"""Readers of training data, on tiny made-up trees of each layout."""

import json

import cv2
import numpy as np
import pytest
from PIL import Image

from footprints_edge.errors import FootprintsError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.mixture import load_datasets
from footprints_edge_models.data.readers.labelled_photos import CAMVID, PhotoLabels, read_photos
from footprints_edge_models.data.readers.rgbd_clip import read_rgbd_clip
from footprints_edge_models.data.readers.stereo_clip import read_stereo_clip
from footprints_edge_models.sample import NO, UNKNOWN, UNSEEN, YES

ROAD, WALL, PERSON, SKY, VOID = 1, 2, 3, 4, 9
LABELS = PhotoLabels(walkable=(ROAD,), void=(VOID,), barriers=(WALL,), sky=(SKY,))


def write_photo(folder, name, ids, image=None):
    (folder / "images").mkdir(parents=True, exist_ok=True)
    (folder / "labels").mkdir(parents=True, exist_ok=True)
    ids = np.asarray(ids, np.uint8)
    image = np.full((*ids.shape, 3), 90, np.uint8) if image is None else image
    Image.fromarray(image).save(folder / "images" / f"{name}.jpg")
    Image.fromarray(ids).save(folder / "labels" / f"{name}.png")


@pytest.fixture
def street_ids():
    """Sky on top, walls below it, road at the bottom; a person and a void on the road."""
    ids = np.full((50, 80), SKY, np.uint8)
    ids[10:30] = WALL
    ids[30:] = ROAD
    ids[20:45, 10:15] = PERSON
    ids[40:, 60:70] = VOID
    return ids


def test_a_labelled_photo(tmp_path, street_ids):
    write_photo(tmp_path / "street", "a", street_ids)
    (sample,) = read_photos(tmp_path / "street", LABELS)
    assert sample.image.shape == (50, 80, 3)
    assert sample.intrinsics == Intrinsics.assumed((50, 80))
    assert sample.visible_depth_m is None
    assert sample.ground_depth_m is None

    road, void = street_ids == ROAD, street_ids == VOID
    assert (sample.visible_ground[road] == YES).all()
    assert (sample.visible_ground[void] == UNKNOWN).all()
    assert (sample.visible_ground[~road & ~void] == NO).all()

    assert (sample.ground[road] == YES).all()
    assert (sample.ground[street_ids == SKY] == NO).all()
    assert (sample.ground[void] == UNKNOWN).all()
    assert (sample.ground[street_ids == PERSON] == UNKNOWN).all()  # who knows what is behind
    # A wall hides no ground far above the highest that is seen; near it, nobody knows.
    wall = street_ids == WALL
    assert (sample.ground[:27][wall[:27]] == NO).all()
    assert (sample.ground[29][wall[29]] == UNKNOWN).all()


def test_a_wall_says_nothing_where_no_ground_is_seen(tmp_path):
    ids = np.full((40, 60), WALL)
    ids[:5] = SKY
    write_photo(tmp_path / "wall", "a", ids)
    (sample,) = read_photos(tmp_path / "wall", LABELS)
    assert (sample.ground[5:] == UNKNOWN).all()
    assert (sample.ground[:5] == NO).all()
    assert (sample.visible_ground == NO).all()


def test_a_large_photo_is_shrunk_with_its_labels_and_camera(tmp_path):
    ids = np.full((600, 1024), WALL)
    ids[300:] = ROAD
    image = np.zeros((600, 1024, 3), np.uint8)
    image[300:] = 200
    write_photo(tmp_path / "big", "a", ids, image)
    (sample,) = read_photos(tmp_path / "big", LABELS)
    assert sample.image.shape == (300, 512, 3)
    assert (sample.visible_ground[:150] == NO).all()
    assert (sample.visible_ground[150:] == YES).all()
    assert sample.image[:145].max() < 60
    assert sample.image[155:].min() > 150
    # A camera's field of view does not change when its picture is resized.
    before = Intrinsics.assumed((600, 1024)).hfov_deg((600, 1024))
    assert sample.intrinsics.hfov_deg((300, 512)) == pytest.approx(before)


def test_labels_of_another_size_are_named(tmp_path, street_ids):
    write_photo(tmp_path / "street", "a", street_ids)
    Image.fromarray(street_ids[:-1]).save(tmp_path / "street" / "labels" / "a.png")
    with pytest.raises(DatasetError, match=r"labels.a\.png.*\(49, 80\).*\(50, 80\)"):
        list(read_photos(tmp_path / "street", LABELS))


def test_coloured_labels_are_refused(tmp_path, street_ids):
    write_photo(tmp_path / "street", "a", street_ids)
    colours = np.zeros((50, 80, 3), np.uint8)
    Image.fromarray(colours).save(tmp_path / "street" / "labels" / "a.png")
    with pytest.raises(DatasetError, match=r"labels.a\.png"):
        list(read_photos(tmp_path / "street", LABELS))


def test_a_missing_label_picture_is_named(tmp_path, street_ids):
    write_photo(tmp_path / "street", "a", street_ids)
    (tmp_path / "street" / "labels" / "a.png").unlink()
    with pytest.raises(DatasetError, match=r"labels.a\.png"):
        list(read_photos(tmp_path / "street", LABELS))


def test_a_missing_folder_of_pictures_is_named(tmp_path):
    with pytest.raises(DatasetError, match=r"images: no such folder"):
        list(read_photos(tmp_path, LABELS))


CLIP_SIZE = (120, 160)
CLIP_CAMERA = Intrinsics(110.0, 110.0, 79.5, 59.5)


@pytest.fixture
def rgbd_clip(tmp_path, scene, box, pose):
    """Ten frames around a crate on a floor; y of the world points down, as gravity does."""
    folder = tmp_path / "clip"
    for name in ("images", "depth"):
        (folder / name).mkdir(parents=True)
    room = scene((box((-0.4, -0.4, 0), (0.4, 0.4, 0.5)),))
    z_up_to_y_down = np.eye(4)
    z_up_to_y_down[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    frames, depths = [], []
    for index, angle in enumerate(np.linspace(0, 2 * np.pi, 10, endpoint=False)):
        at = pose((2.2 * np.cos(angle), 2.2 * np.sin(angle), 1.5), (0, 0, 0.2))
        depth_m = room.depth_m(at, CLIP_CAMERA, CLIP_SIZE)
        depth_m[depth_m > 6] = 0
        name = f"{index:03d}"
        Image.fromarray((depth_m * 1000).astype(np.uint16)).save(folder / "depth" / f"{name}.png")
        Image.fromarray(np.full((*CLIP_SIZE, 3), 10 * index, np.uint8)).save(
            folder / "images" / f"{name}.jpg"
        )
        frames.append({"name": name, "camera_to_world": (z_up_to_y_down @ at).tolist()})
        depths.append(depth_m)
    camera = CLIP_CAMERA
    intrinsics = [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]]
    (folder / "sequence.json").write_text(
        json.dumps({"intrinsics": intrinsics, "frames": frames, "gravity_direction": [0, 1, 0]})
    )
    return folder, frames, depths, z_up_to_y_down


def test_an_rgbd_clip(rgbd_clip):
    folder, frames, depths, z_up_to_y_down = rgbd_clip
    samples = list(read_rgbd_clip(folder))
    assert len(samples) == 10
    rows, columns = np.mgrid[: CLIP_SIZE[0], : CLIP_SIZE[1]].astype(float)
    x, y = (columns - 79.5) / 110, (rows - 59.5) / 110
    hidden_pixels = 0
    for sample, frame, depth_m in zip(samples, frames, depths, strict=True):
        assert sample.image.mean() == pytest.approx(10 * int(frame["name"]), abs=3)
        pose = np.linalg.inv(z_up_to_y_down) @ frame["camera_to_world"]
        rays = np.stack([x, y, np.ones_like(x)], -1) @ pose[:3, :3].T
        floor_m = np.where(rays[..., 2] < 0, -1.5 / rays[..., 2], np.inf)
        points = pose[:3, 3] + floor_m[..., None] * rays
        core = np.abs(points[..., :2]).max(axis=-1) < 0.3
        near = (np.abs(points[..., :2]).max(axis=-1) < 0.9) & ~(
            np.abs(points[..., :2]).max(axis=-1) < 0.55
        )
        seen_floor = (depth_m > 0) & (np.abs(depth_m - floor_m) < 0.01)

        np.testing.assert_allclose(sample.visible_depth_m, depth_m, rtol=2e-3, atol=2e-3)
        known = sample.visible_ground != UNKNOWN
        assert ((sample.visible_ground == YES) == seen_floor)[known].mean() > 0.97
        assert not known[depth_m == 0].any()
        # Colour and depth are a little apart: the border of the floor is nobody's.
        yes, no = sample.visible_ground == YES, sample.visible_ground == NO
        assert not (yes[:, 1:] & no[:, :-1]).any()
        assert not (yes[1:] & no[:-1]).any()

        assert (sample.ground[core] == NO).mean() > 0.97
        hidden = near & ~seen_floor & (depth_m > 0)
        hidden_pixels += hidden.sum()
        assert (sample.ground[hidden] == YES).mean() > 0.9
        assert (sample.ground[seen_floor & near] == YES).mean() > 0.97

        ground = sample.ground == YES
        np.testing.assert_allclose(sample.ground_depth_m[ground], floor_m[ground], rtol=0.02)
        assert not sample.ground_depth_m[~ground].any()
        assert set(np.unique(sample.ground)) <= {NO, YES, UNSEEN}
    assert hidden_pixels > 100


@pytest.mark.parametrize("part", ["images/003.jpg", "depth/003.png", "sequence.json"])
def test_an_rgbd_clip_that_lacks_a_part_says_which(rgbd_clip, part):
    folder, *_ = rgbd_clip
    (folder / part).unlink()
    folder.rename(folder.with_name("hololens_office"))
    with pytest.raises(DatasetError, match=r"hololens_office.*(003|sequence)"):
        load_datasets(folder.parent)


STEREO_SIZE = (180, 500)
FOCAL_PX, BASELINE_M, HEIGHT_M = 350.0, 0.5, 1.6


@pytest.fixture
def stereo_clip(tmp_path):
    """A textured street 1.6 m below two cameras, and a textured wall 12 m ahead."""
    folder = tmp_path / "stereo"
    for name in ("image_l", "image_r"):
        (folder / name).mkdir(parents=True)
    rows, columns = np.mgrid[: STEREO_SIZE[0], : STEREO_SIZE[1]].astype(np.float32)
    fall = np.maximum((rows - 69.5) / FOCAL_PX, 1e-6)
    depth_m = np.minimum(HEIGHT_M / fall, 12.0)
    noise = np.random.default_rng(0).integers(0, 256, (180, 700, 3), dtype=np.uint8)
    right = cv2.GaussianBlur(noise, (0, 0), 1)[:, 100:600]
    # The left picture shows at x what the right one shows at x - disparity.
    disparity = (FOCAL_PX * BASELINE_M / depth_m).astype(np.float32)
    left = cv2.remap(right, columns - disparity, rows, cv2.INTER_LINEAR, None, cv2.BORDER_REFLECT)
    Image.fromarray(left).save(folder / "image_l" / "000000.png")
    Image.fromarray(right).save(folder / "image_r" / "000000.png")
    camera = [FOCAL_PX, 0, 249.5, 0, 0, FOCAL_PX, 69.5, 0, 0, 0, 1, 0]
    shifted = list(camera)
    shifted[3] = -FOCAL_PX * BASELINE_M
    np.savetxt(folder / "calib.txt", [camera, shifted])
    return folder, depth_m


def test_a_stereo_clip(stereo_clip):
    folder, depth_m = stereo_clip
    (sample,) = read_stereo_clip(folder)
    assert sample.intrinsics.fx == pytest.approx(FOCAL_PX)
    inside = np.zeros(STEREO_SIZE, bool)
    inside[10:-5, 150:-10] = True
    measured = inside & (sample.visible_depth_m > 0)
    assert measured.sum() > 0.8 * inside.sum()
    off = np.abs(sample.visible_depth_m[measured] / depth_m[measured] - 1)
    assert np.median(off) < 0.02

    road, wall = inside & (depth_m < 10), inside & (depth_m >= 12)
    assert (sample.visible_ground[road] == YES).mean() > 0.8
    assert (sample.visible_ground[road] == NO).mean() < 0.02
    assert (sample.visible_ground[:100][wall[:100]] == YES).mean() < 0.02
    assert (sample.visible_ground[sample.visible_depth_m == 0] == UNKNOWN).all()

    above = np.arange(STEREO_SIZE[0])[:, None] * np.ones(STEREO_SIZE[1]) < 65
    assert (sample.ground[above] == NO).all()  # above the horizon the street never comes
    assert (sample.ground[80:100][wall[80:100]] == UNKNOWN).mean() > 0.9  # behind the wall
    ground = (sample.ground == YES) & inside
    street_m = HEIGHT_M * FOCAL_PX / (np.arange(STEREO_SIZE[0]) - 69.5)[:, None]
    street_m = np.broadcast_to(street_m, STEREO_SIZE)
    np.testing.assert_allclose(sample.ground_depth_m[ground], street_m[ground], rtol=0.05)


@pytest.mark.parametrize("part", ["image_r/000000.png", "calib.txt"])
def test_a_stereo_clip_that_lacks_a_part_says_which(stereo_clip, part):
    folder, _ = stereo_clip
    (folder / part).unlink()
    folder.rename(folder.with_name("kitti_grey_stereo"))
    with pytest.raises(FootprintsError, match=rf"kitti_grey_stereo.*{part.split('/')[-1]}"):
        load_datasets(folder.parent)


def test_a_stereo_frame_without_road_is_left_out(stereo_clip):
    folder, _ = stereo_clip
    blank = Image.new("RGB", STEREO_SIZE[::-1], (90, 90, 90))
    blank.save(folder / "image_l" / "000001.png")
    blank.save(folder / "image_r" / "000001.png")
    assert [sample.name for sample in read_stereo_clip(folder)] == ["stereo/000000"]


def walls(folder, names):
    for name in names:
        write_photo(folder, name, np.ones((8, 8)))


def test_whole_houses_are_held_out_and_nothing_is_lost(tmp_path):
    names = [f"{house}_{room}" for house in range(60) for room in ("bath", "kitchen")]
    walls(tmp_path / "houses", names)
    (dataset,) = load_datasets(tmp_path).values()
    train, held_out = ({s.name.split("/")[1] for s in p} for p in (dataset.train, dataset.held_out))
    assert not train & held_out
    assert train | held_out == set(names)
    assert len(dataset.train) + len(dataset.held_out) == len(names)
    assert not {n.split("_")[0] for n in train} & {n.split("_")[0] for n in held_out}
    assert 0 < len(held_out) < len(names) / 5


def test_the_end_of_a_clip_is_held_out_after_a_gap(rgbd_clip):
    folder, *_ = rgbd_clip
    folder.rename(folder.with_name("hololens_office"))
    datasets = load_datasets(folder.parent)
    assert list(datasets) == ["hololens_office"]
    dataset = datasets["hololens_office"]
    names = [[s.name.split("/")[1] for s in part] for part in (dataset.train, dataset.held_out)]
    assert names == [[f"{i:03d}" for i in range(7)], ["008", "009"]]


def test_photos_of_streets_come_with_things_set_down_in_them_too(tmp_path):
    ids = np.full((120, 160), 3)
    ids[:40] = 0
    write_photo(tmp_path / "camvid" / "train", "empty", ids)
    ids[50:100, 60:80] = 9
    write_photo(tmp_path / "camvid" / "train", "walker", ids)
    datasets = load_datasets(tmp_path)
    assert list(datasets) == ["camvid", "camvid copy-paste"]
    composites = datasets["camvid copy-paste"].train
    assert len(composites) == 2
    added = [s for s in composites if ((s.visible_ground == NO) & (s.ground == YES)).any()]
    assert added, "nothing hides known ground"


def test_camvid_s_classes(tmp_path):
    ids = np.full((40, 40), 8)
    ids[:10], ids[20:30], ids[30:35], ids[35:] = 0, 3, 4, 11  # sky, road, pavement, void
    write_photo(tmp_path / "camvid" / "train", "a", ids)
    dataset = load_datasets(tmp_path)["camvid"]
    assert dataset.held_out == []
    (sample,) = dataset.train
    assert (sample.visible_ground[20:35] == YES).all()
    assert (sample.visible_ground[35:] == UNKNOWN).all()
    assert (sample.ground[:10] == NO).all()
    assert set(CAMVID.walkable) == {3, 4}


@pytest.mark.parametrize("exists", [True, False])
def test_no_dataset_at_all(tmp_path, exists):
    root = tmp_path / "data"
    if exists:
        root.mkdir()
    with pytest.raises(DatasetError, match=r"data: nothing to train on.* idd_lite, camvid"):
        load_datasets(root)
