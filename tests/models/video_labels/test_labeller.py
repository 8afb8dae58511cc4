"""Labels of a made-up room: a floor, a crate on it and a table over it, seen by a camera that
walks past. Every depth has a closed form."""

from dataclasses import dataclass, replace

import cv2
import numpy as np
import pytest
from PIL import Image

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.sample import nearest
from footprints_edge_models.sequences.folders import read_sequence_folder
from footprints_edge_models.sequences.sequence import (
    Flow,
    InSpace,
    InTime,
    Sequence,
    SequenceError,
    SequenceFrame,
)
from footprints_edge_models.video_labels.labeller import Labeller, LabelSettings
from footprints_edge_models.video_labels.visible_ground import teacher_ground

SIZE = (120, 160)
CAMERA = Intrinsics(130, 130, 79.5, 59.5)
MIDDLE = 6
CRATE = (3.0, -0.4, 0.0), (3.5, 0.4, 0.9)
TABLE = (2.2, 0.8, 0.70), (3.2, 1.6, 0.75)


@dataclass(frozen=True)
class Given:
    """A source that holds what it reads."""

    values: np.ndarray

    def read(self):
        return self.values


@dataclass(frozen=True)
class Broken:
    """A source whose file is damaged."""

    def read(self):
        raise SequenceError("depth.png: no readable depth picture")


@pytest.fixture(scope="session")
def texture():
    noise = np.random.default_rng(0).uniform(0, 255, (*SIZE, 3)).astype(np.float32)
    return cv2.GaussianBlur(noise, (0, 0), 2).astype(np.uint8)


@pytest.fixture
def walk(scene, box, pose, tmp_path, texture):
    """Thirteen frames, the seventh in the middle of a curve around the crate."""
    Image.fromarray(texture).save(tmp_path / "grey.png")
    room = scene((box(*CRATE), box(*TABLE)))
    frames = []
    for time, y in enumerate(np.linspace(-4.5, 4.5, 13)):
        here = pose((0.0, y, 1.6), (3.6, 0.1 * y, 0.0))
        depth_m = room.depth_m(here, CAMERA, SIZE)
        depth_m[depth_m > 12] = 0
        floor_m = scene().depth_m(here, CAMERA, SIZE)
        ground = ((depth_m > 0) & (np.abs(depth_m - floor_m) < 1e-3)).astype(np.float32)
        frames.append(
            SequenceFrame(
                f"{time:05d}",
                time,
                tmp_path / "grey.png",
                CAMERA,
                here,
                Given(depth_m),
                Given(ground),
            )
        )
    return Sequence("walk", tuple(frames), InTime(6, 6, 1), least_hits=1, up=(0.0, 0.0, 1.0))


@pytest.fixture
def on_floor(scene, walk):
    """Of the middle frame: depth of the bare floor, and where each ray meets it, x and y."""
    frame = walk.frames[MIDDLE]
    floor_m = scene().depth_m(frame.camera_to_world, CAMERA, SIZE)
    rows, columns = np.mgrid[: SIZE[0], : SIZE[1]].astype(float)
    x, y = (columns - CAMERA.cx) / CAMERA.fx, (rows - CAMERA.cy) / CAMERA.fy
    rays = np.stack([x, y, np.ones(SIZE)], axis=-1) * floor_m[..., None]
    points = rays @ frame.camera_to_world[:3, :3].T + frame.camera_to_world[:3, 3]
    points[floor_m == 0] = np.inf
    return floor_m, points[..., 0], points[..., 1]


def under(x, y, box, margin_m):
    (x0, y0, _), (x1, y1, _) = box
    return (x > x0 - margin_m) & (x < x1 + margin_m) & (y > y0 - margin_m) & (y < y1 + margin_m)


@pytest.mark.parametrize("ground", ["given", "depth"])
def test_the_floor_goes_on_behind_things_and_not_beneath_them(walk, on_floor, ground):
    labels = Labeller(walk, LabelSettings(ground=ground)).label(MIDDLE)
    floor_m, x, y = on_floor
    label = labels.ground_depth_m > 0
    hidden = label & (labels.ground_probability == 0)
    assert hidden.sum() > 300
    np.testing.assert_allclose(
        labels.ground_depth_m[label], floor_m[label], rtol=0.05
    )  # half a pixel of a steep floor
    assert np.abs(labels.ground_depth_m[label] / floor_m[label] - 1).mean() < 0.01
    # behind the crate, in reach of the others' eyes
    behind = (x > 4.35) & (x < 4.8) & (np.abs(y) < 0.2) & (labels.ground_probability == 0)
    assert behind.sum() > 30
    assert label[behind].mean() > 0.8
    # under the table, past its edge
    beneath = under(x, y, TABLE, -0.2)
    assert label[beneath].mean() > 0.8
    # nobody saw the floor that the crate stands on
    assert not label[under(x, y, CRATE, -0.05)].any()


def test_the_crates_foot_is_untraversable_and_the_table_top_is_not(walk, on_floor):
    labels = Labeller(walk, LabelSettings()).label(MIDDLE)
    _, x, y = on_floor
    assert labels.footprint_mask.sum() > 100
    assert under(x, y, CRATE, 0.16)[labels.footprint_mask].all()
    assert not (labels.footprint_mask & (labels.ground_probability > 0.5)).any()


def test_labels_have_the_size_asked_for_and_metres_stay_metres(walk):
    full = Labeller(walk, LabelSettings()).label(MIDDLE)
    half = Labeller(walk, LabelSettings(size=(60, 80))).label(MIDDLE)
    assert full.ground_depth_m.shape == SIZE
    assert (
        half.ground_depth_m.shape == half.footprint_mask.shape == half.image.shape[:2] == (60, 80)
    )
    assert half.intrinsics.fx == pytest.approx(65)
    both = (half.ground_depth_m > 0) & (full.ground_depth_m[1::2, 1::2] > 0)
    assert both.sum() > 1000
    ratio = half.ground_depth_m[both] / full.ground_depth_m[1::2, 1::2][both]
    assert np.median(np.abs(ratio - 1)) < 0.02


def test_nothing_is_labelled_where_too_few_frames_agree(walk):
    strict = replace(walk, least_hits=13)
    assert not Labeller(strict, LabelSettings()).label(MIDDLE).ground_depth_m.any()


def test_a_neighbour_that_cannot_be_read_is_left_out(walk):
    frames = list(walk.frames)
    frames[1] = replace(frames[1], depth=Broken())
    broken = replace(walk, frames=tuple(frames))
    labels = Labeller(broken, LabelSettings()).label(MIDDLE)
    whole = Labeller(walk, LabelSettings()).label(MIDDLE)
    assert 0 < (labels.ground_depth_m > 0).sum() < (whole.ground_depth_m > 0).sum()
    with pytest.raises(SequenceError, match="no readable depth"):
        Labeller(broken, LabelSettings()).label(1)
    before = Labeller(broken, LabelSettings()).label(0)  # whose flow would lead to it
    assert not before.moving.any()
    assert (before.ground_depth_m > 0).any()


def test_labels_do_not_depend_on_what_was_labelled_before(walk):
    labeller = Labeller(walk, LabelSettings())
    for index in (0, 12, MIDDLE):
        again = labeller.label(index)
    alone = Labeller(walk, LabelSettings()).label(MIDDLE)
    np.testing.assert_array_equal(again.ground_depth_m, alone.ground_depth_m)
    np.testing.assert_array_equal(again.footprint_mask, alone.footprint_mask)
    np.testing.assert_array_equal(again.moving, alone.moving)


def test_without_a_segmentation_the_error_says_what_else_there_is(walk):
    bare = replace(walk, frames=tuple(replace(frame, ground=None) for frame in walk.frames))
    with pytest.raises(SequenceError, match="'depth', 'teacher' or 'model'"):
        Labeller(bare, LabelSettings())


def test_a_floor_needs_to_know_which_way_is_up(walk):
    with pytest.raises(SequenceError, match="which way is up"):
        Labeller(replace(walk, up=None), LabelSettings(ground="depth"))


def test_a_teacher_needs_its_file(walk, tmp_path):
    with pytest.raises(SequenceError, match="needs its"):
        Labeller(walk, LabelSettings(ground="teacher"))
    with pytest.raises(SequenceError, match="no such file"):
        Labeller(walk, LabelSettings(ground="teacher", source=str(tmp_path / "none.tflite")))


def test_the_teacher_says_what_it_said_when_the_label_files_were_made(shared):
    data = shared / "data"
    clip = read_sequence_folder(data / "hololens_office")
    read = teacher_ground(data / "ground_teacher" / "mosaic_r4_ade31_int8.tflite")
    overlap = union = 0
    for frame in clip.frames[::60]:
        file = frame.ground.read() > 0.5
        seen = nearest(read(frame), file.shape) > 0.5
        overlap += (seen & file).sum()
        union += (seen | file).sum()
    assert overlap / union > 0.9


def test_given_flow_is_scaled_to_the_labels(walk):
    """Flow from a file, at half the size; the file says that a patch went its own way."""
    frame, other = walk.frames[MIDDLE], walk.frames[MIDDLE + 1]
    labeller = Labeller(walk, LabelSettings())
    depth_m = labeller.label(MIDDLE).visible_depth_m
    rows, columns = np.mgrid[: SIZE[0], : SIZE[1]].astype(float)
    x, y = (columns - CAMERA.cx) / CAMERA.fx, (rows - CAMERA.cy) / CAMERA.fy
    points = np.stack([x * depth_m, y * depth_m, depth_m], axis=-1)
    move = np.linalg.inv(other.camera_to_world) @ frame.camera_to_world
    x, y, z = np.moveaxis(points @ move[:3, :3].T + move[:3, 3], -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.stack([CAMERA.fx * x / z + CAMERA.cx, CAMERA.fy * y / z + CAMERA.cy], axis=-1)
    flow_px = (ends - np.stack([columns, rows], axis=-1)).astype(np.float32)
    inside = (depth_m > 0) & (ends[..., 0] > 2) & (ends[..., 0] < 157) & (ends[..., 1] < 117)
    patch = np.zeros(SIZE, bool)
    patch[90:110, 60:100] = True
    flow_px[patch] += 8
    flow_px[depth_m == 0] = 0
    flow = Flow(Given(flow_px[::2, ::2] / 2), other.name)
    frames = list(walk.frames)
    frames[MIDDLE] = replace(frame, flow=flow)
    moving = Labeller(replace(walk, frames=tuple(frames)), LabelSettings()).label(MIDDLE).moving
    core = np.zeros(SIZE, bool)
    core[94:106, 66:94] = True
    assert moving[core & inside].mean() > 0.95
    smooth = np.zeros(SIZE, bool)
    smooth[70:84, 10:50] = True  # floor, far from the patch and from any edge
    assert not moving[smooth & inside].any()


def test_pictures_that_are_no_video_have_nothing_moving(walk):
    still = replace(walk, neighbours=InSpace((10.0, 10.0, 10.0)))
    assert not Labeller(still, LabelSettings()).label(MIDDLE).moving.any()


def test_the_default_model_can_say_what_is_ground(walk):
    labels = Labeller(walk, LabelSettings(ground="model")).label(MIDDLE)
    assert labels.ground_probability.shape == SIZE
    assert 0 <= labels.ground_probability.min() <= labels.ground_probability.max() <= 1
