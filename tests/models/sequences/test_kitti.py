"""KITTI raw and its published training data, on a made-up drive over a flat street."""

import shutil
from zipfile import ZipFile

import numpy as np
import pytest
from PIL import Image

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.mixture import load_datasets
from footprints_edge_models.data.readers.published_kitti import read_kitti_training
from footprints_edge_models.sample import NO, UNSEEN, YES
from footprints_edge_models.sequences.kitti import Disparity, read_kitti_raw
from footprints_edge_models.sequences.layouts import read_sequence
from footprints_edge_models.sequences.npy_files import NpyFile
from footprints_edge_models.sequences.sequence import InTime, SequenceError, StereoPair
from footprints_edge_models.video_labels.labeller import Labeller, LabelSettings

DATE = "2011_09_26"
DRIVE = f"{DATE}/{DATE}_drive_0001_sync"
SIZE = HEIGHT, WIDTH = (60, 160)
CAMERA = Intrinsics(0.58 * WIDTH, 1.92 * HEIGHT, 0.5 * WIDTH, 0.5 * HEIGHT)
STANDS_M = 1.65
FRAMES = 6


def street_m(size=SIZE):
    """Depth (h, w) of a flat street below the camera, 0 at and above the horizon."""
    rows = np.arange(size[0])[:, None] + np.zeros(size[1])
    below = np.maximum(rows - 0.5 * size[0], 0)
    with np.errstate(divide="ignore"):
        return np.where(below > 0, STANDS_M * 1.92 * size[0] / below, 0)


def save(path, array):
    path.parent.mkdir(parents=True, exist_ok=True)
    np.save(path, array)


@pytest.fixture
def raw(tmp_path):
    """Pictures of both cameras, without calibration."""
    raw = tmp_path / "kitti_raw"
    for camera in ("image_02", "image_03"):
        folder = raw / DRIVE / camera / "data"
        folder.mkdir(parents=True)
        for time in range(FRAMES):
            grey = np.full((*SIZE, 3), 20 * time, np.uint8)
            Image.fromarray(grey).save(folder / f"{time:010d}.{'jpg' if time % 2 else 'png'}")
    return raw


@pytest.fixture
def published(tmp_path):
    """What the published training data holds of the drive: half a metre ahead a frame."""
    root = tmp_path / "kitti_training_data"
    depth_m = street_m()
    seen = (depth_m > 0) & (depth_m < 20)
    disparity_px = np.where(depth_m > 0, 0.58 * WIDTH * 0.54 / np.maximum(depth_m, 1e-9), 0)
    for time in range(FRAMES):
        name = f"{time:010d}.npy"
        pose = np.eye(4)[:3]
        pose[2, 3] = 0.5 * time
        save(root / "poses" / DRIVE / "orbslam_poses" / name, pose.ravel())
        for camera in ("image_02", "image_03"):
            save(root / "stereo_matching_disps" / DRIVE / camera / name, disparity_px)
            place = f"{DRIVE}/{camera}/data/{name}"
            save(root / "ground_seg" / place, np.where(seen, 0.9, 0.2)[None].astype(np.float32))
            save(root / "optical_flow" / place, np.stack([np.full(SIZE, 2.0), np.zeros(SIZE)]))
            save(root / "hidden_depths" / place, np.where(seen, depth_m, 0))
            save(root / "moving_objects" / place, np.zeros(SIZE))
    return root


def packed(folder, wrapped):
    path = folder.with_suffix(".zip")
    with ZipFile(path, "w") as archive:
        for file in sorted(folder.rglob("*.npy")):
            archive.write(file, file.relative_to(folder.parent if wrapped else folder))
    shutil.rmtree(folder)
    return path


def test_a_drive_with_published_data(raw, published):
    sequence = read_kitti_raw(raw, DRIVE, published)
    assert len(sequence.frames) == 2 * FRAMES
    assert sequence.neighbours == InTime(25, 50, 2)
    assert sequence.least_hits == 2
    assert sequence.up == (0, -1, 0)
    names = [frame.name for frame in sequence.frames]
    assert names[:3] == ["image_02/0000000000", "image_03/0000000000", "image_02/0000000001"]
    for frame in sequence.frames:
        assert frame.intrinsics == CAMERA
        place = [0.54 if frame.name.startswith("image_03") else 0, 0, 0.5 * frame.time]
        np.testing.assert_allclose(frame.camera_to_world[:3, 3], place)
        np.testing.assert_allclose(frame.depth.read(), street_m(), rtol=1e-5)
        assert frame.ground.read().shape == SIZE
        # Flow leads back; the first frame has nothing behind it.
        camera, to = frame.name[:8], frame.time - 1 if frame.time else 1
        assert frame.flow.to == f"{camera}/{to:010d}"
        assert frame.flow.source.read().shape == (*SIZE, 2)
        assert (frame.flow.source.read()[..., 0] == 2).all()


def test_its_labels_are_the_street(raw, published):
    sequence = read_kitti_raw(raw, DRIVE, published)
    labels = Labeller(sequence, LabelSettings()).label(0)
    depth_m = street_m()
    below = np.arange(HEIGHT)[:, None] - 0.5 * HEIGHT + np.zeros(WIDTH)
    labelled = labels.ground_depth_m > 0
    assert labelled.mean() > 0.2
    assert not labelled[: HEIGHT // 2 + 1].any()
    # Warping rounds to half a pixel, and half a row is so much of the depth:
    off = np.abs(labels.ground_depth_m / np.maximum(depth_m, 1e-9) - 1)
    assert (off[labelled] <= 0.55 / below[labelled]).all()


@pytest.mark.parametrize("wrapped", [True, False])
def test_a_zip_reads_like_the_folder_that_it_was_made_of(raw, published, wrapped):
    before = read_kitti_raw(raw, DRIVE, published)
    expected = [(f.name, f.depth.read(), f.ground.read()) for f in before.frames]
    after = read_kitti_raw(raw, DRIVE, packed(published, wrapped))
    for frame, (name, depth_m, ground) in zip(after.frames, expected, strict=True):
        assert frame.name == name
        np.testing.assert_array_equal(frame.depth.read(), depth_m)
        np.testing.assert_array_equal(frame.ground.read(), ground)
        assert frame.flow is not None


def test_disparities_of_another_size_are_the_same_depth(tmp_path):
    for width in (WIDTH, WIDTH // 2):
        disparity_px = np.full((10, width), 0.58 * width * 0.54 / 8.0)
        disparity_px[0] = 0
        save(tmp_path / f"{width}.npy", disparity_px)
        depth_m = Disparity(NpyFile(tmp_path, f"{width}.npy"), 0.58, 0.54).read()
        np.testing.assert_allclose(depth_m[1:], 8.0, rtol=1e-6)
        assert not depth_m[0].any()


def test_frames_that_were_lost_are_left_out(raw, published):
    for time in (2, 3):
        (published / "poses" / DRIVE / "orbslam_poses" / f"{time:010d}.npy").unlink()
    sequence = read_kitti_raw(raw, DRIVE, published)
    assert sorted({frame.time for frame in sequence.frames}) == [0, 1, 4, 5]
    # The flow of frame 4 leads to a frame without a pose: it is of no use.
    assert [f.flow is None for f in sequence.frames if f.time == 4] == [True, True]


def test_without_published_disparities_the_pair_is_matched(raw, published):
    shutil.rmtree(published / "stereo_matching_disps")
    sequence = read_kitti_raw(raw, DRIVE, published)
    assert {frame.name[:8] for frame in sequence.frames} == {"image_02"}
    depth = sequence.frames[0].depth
    assert isinstance(depth, StereoPair)
    assert depth.right == raw / DRIVE / "image_03" / "data" / "0000000000.png"
    assert depth.focal_times_baseline == pytest.approx(0.58 * WIDTH * 0.54)


def test_without_any_poses_it_says_where_they_come_from(raw):
    with pytest.raises(SequenceError, match=r"orbslam_poses.*oxts"):
        read_kitti_raw(raw, DRIVE)
    with pytest.raises(SequenceError, match="no pictures of the left camera"):
        read_kitti_raw(raw, f"{DATE}/nothing")


def calibrate(raw):
    """A calibration with simple numbers: the left colour camera 6 cm right of camera 0."""
    folder = raw / DATE
    projection = "P_rect_0{}: 100 0 81 {} 0 101 29 0 0 0 1 0\n"
    (folder / "calib_cam_to_cam.txt").write_text(
        "calib_time: 09-Jan-2012 13:57:47\nR_rect_00: 1 0 0 0 1 0 0 0 1\n"
        + projection.format(2, -6)
        + projection.format(3, -59)
    )
    (folder / "calib_imu_to_velo.txt").write_text("R: 1 0 0 0 1 0 0 0 1\nT: 0 0 0.8\n")
    # x ahead, y left, z up of the scanner; x right, y down, z ahead of the camera
    (folder / "calib_velo_to_cam.txt").write_text("R: 0 -1 0 0 0 -1 1 0 0\nT: 0 0 0\n")


def test_calibration_and_gps_records(raw):
    """A car heads east and drives two metres a frame in that direction."""
    calibrate(raw)
    oxts = raw / DRIVE / "oxts" / "data"
    oxts.mkdir(parents=True)
    latitude, longitude = 49.0, 8.4
    metre = np.degrees(1 / (6378137 * np.cos(np.radians(latitude))))
    for time in range(FRAMES):
        record = [latitude, longitude + 2 * time * metre, 112, 0, 0, 0, *np.zeros(24)]
        (oxts / f"{time:010d}.txt").write_text(" ".join(f"{value:.14f}" for value in record))
    sequence = read_sequence(raw / DRIVE)
    assert sequence.up == (0, 0, 1)
    for frame in sequence.frames:
        assert frame.intrinsics == Intrinsics(100, 101, 81, 29)
        assert frame.depth.focal_times_baseline == pytest.approx(53)
        right, down, ahead = frame.camera_to_world[:3, :3].T
        np.testing.assert_allclose(right, [0, -1, 0], atol=1e-9)
        np.testing.assert_allclose(down, [0, 0, -1], atol=1e-9)
        np.testing.assert_allclose(ahead, [1, 0, 0], atol=1e-9)
        # The scanner's axes are 0.8 m below the inertial unit's; the camera 6 cm to the right.
        place = frame.camera_to_world[:3, 3]
        np.testing.assert_allclose(place, [2 * frame.time, -0.06, -0.8], atol=1e-5)


def test_a_turned_car_has_turned_cameras(raw):
    calibrate(raw)
    oxts = raw / DRIVE / "oxts" / "data"
    oxts.mkdir(parents=True)
    roll, pitch, yaw = 0.02, -0.03, np.pi / 2
    (oxts / "0000000000.txt").write_text(f"49 8.4 112 {roll} {pitch} {yaw} " + "0 " * 24)
    pose = read_kitti_raw(raw, DRIVE).frames[0].camera_to_world
    ahead, down = pose[:3, 2], pose[:3, 1]
    # Yaw counts from east to north; a positive pitch turns the nose down.
    np.testing.assert_allclose(ahead, [0, np.cos(pitch), -np.sin(pitch)], atol=1e-9)
    assert -down @ [0, 0, 1] == pytest.approx(np.cos(pitch) * np.cos(roll))


def split_lines():
    return [f"{DRIVE} {time} {side}\n" for time in range(FRAMES) for side in "lr"]


def test_published_labels_as_samples(raw, published):
    place = f"{DRIVE}/image_02/data/0000000003.npy"
    mask, moving = np.zeros(SIZE), np.zeros(SIZE)
    mask[20:24, 30:34] = 1
    mask[5:15, 40:80] = 1  # more than a hundredth of the picture: a mistake
    moving[:, 30:40] = 1
    hidden_m = np.load(published / "hidden_depths" / place)
    hidden_m[20:24, 30:44] = 9.0
    save(published / "depth_masks" / place, mask)
    save(published / "moving_objects" / place, moving)
    save(published / "hidden_depths" / place, hidden_m)
    samples = list(read_kitti_training(raw, published, split_lines()))
    assert len(samples) == 2 * FRAMES
    sample = samples[6]
    assert sample.name == f"{DRIVE}/image_02/0000000003"
    assert sample.image.mean() == pytest.approx(60, abs=2)
    assert sample.intrinsics == CAMERA
    depth_m = street_m()
    seen = (depth_m > 0) & (depth_m < 20)
    np.testing.assert_array_equal(sample.visible_ground == YES, seen)
    assert (sample.ground[20:24, 30:34] == NO).all()
    assert (sample.ground[20:24, 34:44] == YES).all()
    assert (sample.ground[seen] == YES).all()
    assert (sample.ground[5:15, 40:80] == UNSEEN).all()
    assert (sample.ground_depth_m[20:24, 34:44] == 9).all()
    assert not sample.ground_depth_m[20:24, 30:34].any()
    np.testing.assert_allclose(sample.ground_depth_m[seen], depth_m[seen], rtol=1e-3)
    # What moves counts where nothing else is known for sure.
    expected = np.zeros(SIZE, bool)
    expected[:, 30:40] = True
    expected[20:24, 30:34] = False
    np.testing.assert_array_equal(sample.moving == 1, expected & ~seen)
    # The published training takes 1.25 px of a 640 px wide disparity off.
    near_m = 0.58 * 640 * 0.54 / (0.58 * 640 * 0.54 / depth_m[50, 9] - 1.25)
    assert sample.visible_depth_m[50, 9] == pytest.approx(near_m, rel=1e-3)
    # Without masks nobody says what is untraversable.
    assert not (samples[0].ground == NO).any()


@pytest.mark.parametrize(
    ("line", "says"),
    [
        (f"{DRIVE} 3", "is not 'drive frame side'"),
        (f"{DRIVE} three l", "is not 'drive frame side'"),
        (f"{DRIVE} 3 m", "is not 'drive frame side'"),
        (f"{DRIVE} 99 l", r"no picture 0000000099\.jpg or \.png"),
    ],
)
def test_lines_that_name_nothing_are_named(raw, published, line, says):
    with pytest.raises(SequenceError, match=says):
        list(read_kitti_training(raw, published, [line]))


def test_missing_and_damaged_labels_are_named(raw, published):
    place = published / "ground_seg" / DRIVE / "image_02" / "data" / "0000000003.npy"
    place.write_bytes(place.read_bytes()[:100])
    with pytest.raises(SequenceError, match=r"ground_seg.*0000000003\.npy"):
        list(read_kitti_training(raw, published, [f"{DRIVE} 3 l"]))
    place.unlink()
    with pytest.raises(SequenceError, match=r"ground_seg.*0000000003\.npy"):
        list(read_kitti_training(raw, packed(published, True), [f"{DRIVE} 3 l"]))


def test_they_are_found_as_training_data(raw, published):
    with pytest.raises(DatasetError, match=r"train\.txt"):
        load_datasets(raw.parent)
    (raw / "train.txt").write_text("".join(split_lines()))
    packed(published, True)
    datasets = load_datasets(raw.parent)
    assert len(datasets["kitti_raw"].train) + len(datasets["kitti_raw"].held_out) == 2 * FRAMES
    (raw.parent / "kitti_training_data.zip").unlink()
    with pytest.raises(DatasetError, match=r"kitti_training_data"):
        load_datasets(raw.parent)
