"""Clips in the formats that people have: poses, cameras and depth are those of the made-up world.

Each writer follows the format's documentation; the world is a floor with a box on it, seen by a ray
caster of the tests' own, so that depth lifted by pose and camera must lie on it.
"""

import json
import math
import pickle

import cv2
import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import decode
from footprints_edge_models.cli import app
from footprints_edge_models.sequences.layouts import read_sequence
from footprints_edge_models.sequences.sequence import SequenceError
from footprints_edge_models.video_labels.visible_ground import best_ground

SIZE = (48, 64)
CAMERA = Intrinsics(52.0, 50.0, 30.0, 25.0)
EYES = [(2.6, 0.4, 1.4), (0.3, 2.7, 1.2), (-2.5, -0.2, 1.5), (-0.4, -2.6, 1.3)]
RATE = 30
"""Colour pictures a second; three in a row show the same eye, so that every third is kept."""


COLMAP_WORLD = np.eye(4)
"""From a world whose z axis is up to one whose axes have nothing to do with up."""
COLMAP_WORLD[:3, :3] = Rotation.from_rotvec([0.7, -1.1, 0.4]).as_matrix()


@pytest.fixture
def world(scene, box):
    """What a sensor that reaches 6 m sees of a floor with a box on it."""

    class Seen(scene):
        def depth_m(self, *view):
            depth_m = super().depth_m(*view)
            return np.where(depth_m < 6, depth_m, 0).astype(np.float32)

    return Seen((box((-0.4, -0.3, 0.0), (0.5, 0.4, 0.6)),))


@pytest.fixture
def eyes(pose):
    """Camera-to-world poses; z is up."""
    return [pose(eye, (0.05, 0.1, 0.2)) for eye in EYES]


def save_picture(path, shade, size=SIZE):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.full((*size, 3), shade, np.uint8)).save(path)


def save_depth(path, depth_m, units_per_m=1000):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(np.rint(depth_m * units_per_m).astype(np.uint16)).save(path)


@pytest.fixture
def tum(tmp_path, world, eyes):
    folder = tmp_path / "desk"
    rgb, depth, truth = (["# a comment"] for _ in range(3))
    for index in range(3 * len(eyes)):
        place, time_s = eyes[index // 3], 1305031102.1753 + index / RATE
        save_picture(folder / f"rgb/{time_s:.6f}.png", 10 * index)
        save_depth(
            folder / f"depth/{time_s + 0.004:.6f}.png", world.depth_m(place, CAMERA, SIZE), 5000
        )
        rgb.append(f"{time_s:.6f} rgb/{time_s:.6f}.png")
        depth.append(f"{time_s + 0.004:.6f} depth/{time_s + 0.004:.6f}.png")
        numbers = [*place[:3, 3], *Rotation.from_matrix(place[:3, :3]).as_quat()]
        truth.append(" ".join([f"{time_s - 0.003:.4f}", *(f"{value:.6f}" for value in numbers)]))
    for name, lines in (("rgb", rgb), ("depth", depth), ("groundtruth", truth)):
        (folder / f"{name}.txt").write_text("\n".join(lines) + "\n")
    (folder / "calibration.txt").write_text("# fx fy cx cy\n52 50 30 25\n")
    return folder


@pytest.fixture
def scannet(tmp_path, world, eyes):
    """Depth is half as large as colour; one frame lost its tracking."""
    folder = tmp_path / "scene0000_00"
    half = (SIZE[0] // 2, SIZE[1] // 2)
    for number in range(0, 3 * len(eyes) + 3, 3):
        place = eyes[number // 3] if number // 3 < len(eyes) else np.full((4, 4), -np.inf)
        save_picture(folder / f"color/{number}.jpg", 10 * number)
        if np.isfinite(place).all():
            depth_m = world.depth_m(place, CAMERA.scaled(SIZE, half), half)
            save_depth(folder / f"depth/{number}.png", depth_m)
        (folder / "pose").mkdir(exist_ok=True)
        np.savetxt(folder / f"pose/{number}.txt", place, fmt="%.6f")
    matrix = np.eye(4)
    matrix[:3, :3] = CAMERA.matrix
    (folder / "intrinsic").mkdir()
    np.savetxt(folder / "intrinsic/intrinsic_color.txt", matrix)
    return folder


def y_up(pose):
    """A pose whose world has z up, in one whose world has y up."""
    turn = np.eye(4)
    turn[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    return turn @ pose


ON_ITS_SIDE = np.array([[0.0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
"""From the axes of the app's sensor, x down and y left, to those of a phone held upright."""


@pytest.fixture
def stray(tmp_path, world, eyes):
    """A phone held upright, whose sensor lies on its side."""
    return stray_folder(tmp_path / "5f2a", world, eyes, ON_ITS_SIDE)


@pytest.fixture
def stray_lying(tmp_path, world, eyes):
    """A phone held on its side, whose sensor stands upright."""
    return stray_folder(tmp_path / "5f2b", world, eyes, np.eye(4))


def stray_folder(folder, world, eyes, turn):
    folder.mkdir()
    video = cv2.VideoWriter(
        str(folder / "rgb.mp4"), cv2.VideoWriter_fourcc(*"mp4v"), 60, SIZE[::-1]
    )
    lines = ["timestamp, frame, x, y, z, qx, qy, qz, qw"]
    for number in range(6 * len(eyes)):
        place = eyes[number // 6] @ turn
        video.write(np.full((*SIZE, 3), 20 + 8 * number, np.uint8))
        depth_m = world.depth_m(place, CAMERA, SIZE)
        save_depth(folder / f"depth/{number:06d}.png", depth_m)
        confidence = np.full(SIZE, 2, np.uint8)
        confidence[:, :3] = 0
        (folder / "confidence").mkdir(exist_ok=True)
        Image.fromarray(confidence).save(folder / f"confidence/{number:06d}.png")
        stated = y_up(place)
        numbers = [*stated[:3, 3], *Rotation.from_matrix(stated[:3, :3]).as_quat()]
        lines.append(f"{100 + number / 60:.6f}, {number:06d}, " + ", ".join(map(str, numbers)))
    video.release()
    (folder / "odometry.csv").write_text("\n".join(lines))
    rows = (", ".join(map(str, row)) for row in CAMERA.matrix)
    (folder / "camera_matrix.csv").write_text("\n".join(rows))
    return folder


@pytest.fixture
def record3d(tmp_path, world, eyes):
    """A phone held upright, whose depth is half as large as its pictures."""
    codecs = pytest.importorskip("imagecodecs", reason="depth of Record3D is compressed by LZFSE")
    folder, half = tmp_path / "walk", (SIZE[0] // 2, SIZE[1] // 2)
    poses = []
    for number in range(6 * len(eyes)):
        place = eyes[number // 6]
        save_picture(folder / f"rgbd/{number}.jpg", 20 + 8 * number)
        depth_m = world.depth_m(place, CAMERA.scaled(SIZE, half), half)
        confidence = np.full(half, 2, np.uint8)
        confidence[-5:, 0], depth_m[-5:, 0], depth_m[-5:, 1] = 0, 77, np.nan
        for suffix, values in (("depth", depth_m), ("conf", confidence)):
            path = folder / f"rgbd/{number}.{suffix}"
            path.write_bytes(codecs.lzfse_encode(values.tobytes()))
        stated = y_up(place) @ np.diag([1, -1, -1, 1])
        poses.append([*Rotation.from_matrix(stated[:3, :3]).as_quat(), *stated[:3, 3]])
    about = {"w": SIZE[1], "h": SIZE[0], "fps": 60, "K": CAMERA.matrix.T.ravel().tolist()}
    (folder / "metadata").write_text(json.dumps({**about, "poses": poses}))
    return folder


def colmap_folder(folder, world, eyes, dense):
    images = ["# two lines a picture"]
    for index, place in enumerate(eyes):
        name = f"walk/{index}.jpg"
        save_picture(folder / "images" / name, 10 * index)
        depth_m = world.depth_m(place, CAMERA, SIZE)
        if dense:
            path = folder / f"stereo/depth_maps/{name}.geometric.bin"
            path.parent.mkdir(parents=True, exist_ok=True)
            header = f"{SIZE[1]}&{SIZE[0]}&1&".encode()
            path.write_bytes(header + depth_m.astype("<f4").tobytes())
        else:
            save_depth(folder / f"depth/walk/{index}.png", depth_m)
        to_camera = np.linalg.inv(COLMAP_WORLD @ place)
        x, y, z, w = Rotation.from_matrix(to_camera[:3, :3]).as_quat()
        numbers = " ".join(map(str, (w, x, y, z, *to_camera[:3, 3])))
        images += [f"{7 - index} {numbers} 3 {name}", "" if index % 2 else "1.5 2.5 -1"]
    model = folder / ("sparse/0" if dense else ".")
    model.mkdir(parents=True, exist_ok=True)
    (model / "images.txt").write_text("\n".join(images) + "\n")
    (model / "cameras.txt").write_text("# cameras\n3 PINHOLE 64 48 52 50 30.5 25.5\n")
    return folder


@pytest.fixture
def colmap(tmp_path, world, eyes):
    return colmap_folder(tmp_path / "walk", world, eyes, dense=False)


@pytest.fixture
def colmap_dense(tmp_path, world, eyes):
    return colmap_folder(tmp_path / "walk", world, eyes, dense=True)


FORMATS = ["tum", "scannet", "stray", "stray_lying", "record3d", "colmap", "colmap_dense"]


@pytest.mark.parametrize("name", FORMATS)
def test_depth_lifted_into_the_world_lies_on_its_surfaces(request, name, eyes):
    sequence = read_sequence(request.getfixturevalue(name))
    assert len(sequence.frames) == len(eyes)
    assert [frame.time for frame in sequence.frames] == list(range(len(eyes)))
    assert pickle.loads(pickle.dumps(sequence)).name == sequence.name
    up = np.array(sequence.up) / np.linalg.norm(sequence.up)
    if name.startswith("colmap"):
        assert up @ COLMAP_WORLD[:3, 2] > np.cos(np.radians(1))
        up = COLMAP_WORLD[:3, 2]
    for frame, eye in zip(sequence.frames, eyes, strict=True):
        measured = frame.measured()
        known = measured.depth_m > 0
        assert known.mean() > 0.6
        points = measured.points()[known]
        heights = points @ up
        floor, top = np.abs(heights) < 0.002, np.abs(heights - 0.6) < 0.002
        sides = (heights > 0) & (heights < 0.6) & ~floor & ~top
        assert (floor | top | sides).all()
        assert floor.mean() > 0.4 and top.sum() > 5 and sides.sum() > 5
        assert frame.camera_to_world[:3, 3] @ up == pytest.approx(eye[2, 3], abs=0.002)


@pytest.mark.parametrize("name", FORMATS)
def test_pictures_are_upright_and_cameras_those_of_the_pictures(request, name, world, eyes):
    sequence = read_sequence(request.getfixturevalue(name))
    for frame, eye in zip(sequence.frames, eyes, strict=True):
        up = np.array(sequence.up) / np.linalg.norm(sequence.up)
        assert frame.camera_to_world[:3, 1] @ up < -0.7  # the y axis points down
        image = decode(frame.image).rgb
        assert (image.shape[0], image.shape[1]) == frame.image_size()
        measured = frame.measured()
        own = measured.depth_m.shape
        expected = world.depth_m(eye, measured.intrinsics, own)
        known = measured.depth_m > 0
        error_m = np.abs(measured.depth_m - expected)[known]
        assert np.mean(error_m < 0.002) > 0.995


def test_time_stamps_are_matched_and_frames_thinned(tum):
    sequence = read_sequence(tum)
    shades = [int(decode(frame.image).rgb.mean()) for frame in sequence.frames]
    assert shades == [0, 30, 60, 90]
    assert best_ground(sequence) == "depth"


def test_a_kinect_is_assumed_for_its_own_size_only(tum):
    (tum / "calibration.txt").unlink()
    with pytest.raises(SequenceError, match=r"64x48 pixels.*calibration\.txt"):
        read_sequence(tum)
    for path in (tum / "rgb").iterdir():
        save_picture(path, 50, (480, 640))
    assert read_sequence(tum).frames[0].intrinsics == Intrinsics(525.0, 525.0, 319.5, 239.5)


def test_frames_of_a_video_are_taken_out_once(stray):
    sequence = read_sequence(stray)
    shades = [decode(frame.image).rgb.mean() for frame in sequence.frames]
    assert shades == pytest.approx([20, 68, 116, 164], abs=6)
    (stray / "rgb.mp4").rename(stray / "moved.mp4")
    (stray / "rgb.mp4").write_bytes((stray / "moved.mp4").read_bytes())
    before = {path: path.stat().st_mtime_ns for path in (stray / "frames").iterdir()}
    read_sequence(stray)
    assert {path: path.stat().st_mtime_ns for path in (stray / "frames").iterdir()} == before
    assert not list(stray.glob(".fp-*"))


@pytest.mark.parametrize(
    ("name", "spoil", "says"),
    [
        ("tum", lambda f: (f / "depth.txt").unlink(), r"depth\.txt"),
        ("tum", lambda f: (f / "groundtruth.txt").write_text("1 0 0 0 0 0 0 1\n"), "both depth"),
        ("tum", lambda f: (f / "rgb.txt").write_text("now rgb/a.png\n"), "not numbers"),
        ("tum", lambda f: (f / "calibration.txt").write_text("5 5 0\n"), "fx fy cx cy"),
        ("scannet", lambda f: (f / "intrinsic/intrinsic_color.txt").unlink(), "intrinsic_color"),
        ("scannet", lambda f: (f / "depth/3.png").unlink(), r"3\.png: missing"),
        ("scannet", lambda f: (f / "pose/3.txt").write_text("1 2\n3 4\n"), "4x4"),
        ("stray", lambda f: (f / "odometry.csv").write_text("x, y\n1, 2\n"), "no column timestamp"),
        ("stray", lambda f: (f / "rgb.mp4").unlink(), "no readable video"),
        ("stray", lambda f: (f / "depth/000006.png").unlink(), "000006.png: missing"),
        ("stray", lambda f: (f / "camera_matrix.csv").write_text("a"), "3x3"),
        ("record3d", lambda f: (f / "metadata").write_text("{}"), "no readable metadata"),
        ("record3d", lambda f: restate(f, h=math.inf), "no readable metadata"),
        ("record3d", lambda f: (f / "metadata").write_text("[" * 99999), "no readable metadata"),
        ("record3d", lambda f: (f / "rgbd/6.depth").unlink(), r"6\.depth: missing"),
        ("record3d", lambda f: (f / "rgbd/6.jpg").unlink(), r"6\.jpg: missing"),
        ("colmap", lambda f: spoil_colmap(f, "cameras.txt", "OPENCV", "0.1 0 0 0"), "undistort"),
        ("colmap", lambda f: (f / "images/walk/1.jpg").unlink(), "no such picture"),
        ("colmap", lambda f: spoil_colmap(f, "cameras.txt", "ORTHO", ""), "image_undistorter"),
    ],
)
def test_what_is_missing_or_odd_is_named(request, name, spoil, says):
    folder = request.getfixturevalue(name)
    spoil(folder)
    with pytest.raises(SequenceError, match=says):
        read_sequence(folder)


def test_damaged_depth_of_record3d_is_told(record3d):
    depth = record3d / "rgbd/0.depth"
    depth.write_bytes(b"nonsense")
    with pytest.raises(SequenceError, match=r"0\.depth: not readable"):
        read_sequence(record3d).frames[0].depth.read()


def restate(folder, **facts):
    path = folder / "metadata"
    path.write_text(json.dumps(json.loads(path.read_text()) | facts))


def spoil_colmap(folder, name, model, more):
    (path,) = folder.rglob(name)
    path.write_text(path.read_text().replace("PINHOLE", model).replace("25.5", f"25.5 {more}"))


def test_up_is_known_from_cameras_that_all_look_the_same_way_down(tmp_path, world, pose):
    eyes = [pose((x, -2.5, 1.5), (x, 0.0, 0.3)) for x in (-0.4, 0.0, 0.4)]
    sequence = read_sequence(colmap_folder(tmp_path / "aisle", world, eyes, dense=False))
    # nothing says how far down they look; they are no more tilted than that
    pitch = np.arctan2(1.2, 2.5)
    assert np.dot(sequence.up, COLMAP_WORLD[:3, 2]) == pytest.approx(np.cos(pitch), abs=1e-3)


def test_a_binary_reconstruction_says_how_to_write_text(colmap):
    for name in ("cameras", "images"):
        (path,) = colmap.rglob(f"{name}.txt")
        path.rename(path.with_suffix(".bin"))
    with pytest.raises(SequenceError, match="model_converter"):
        read_sequence(colmap)


def test_a_video_that_ends_early_leaves_nothing_half_written(stray):
    path = stray / "odometry.csv"
    last = path.read_text().splitlines()[-1].split(", ")
    path.write_text(path.read_text() + "\n" + ", ".join(["200", "000099", *last[2:]]))
    with pytest.raises(SequenceError, match="ends at frame 24"):
        read_sequence(stray)
    assert not list(stray.glob(".fp-*")) and not (stray / "frames").exists()


def test_labels_are_made_without_saying_where_ground_comes_from(tum, tmp_path):
    out = tmp_path / "labels"
    result = CliRunner().invoke(app, ["labels", str(tum), "-o", str(out), "--jobs", "1"])
    assert result.exit_code == 0, result.output
    summary = json.loads(result.stdout)
    assert (summary["ground"], summary["frames"], summary["failed"]) == ("depth", 4, 0)


def spoil(path, before, after):
    text = path.read_text()
    assert before in text
    path.write_text(text.replace(before, after, 1))


def test_frame_numbers_that_cannot_be_are_refused(stray):
    for number in ("inf", "nan", "-1", "1e300"):
        text = (stray / "odometry.csv").read_text()
        spoil(stray / "odometry.csv", ", 000000,", f", {number},")
        with pytest.raises(SequenceError, match="no frame number"):
            read_sequence(stray)
        (stray / "odometry.csv").write_text(text)


def test_pictures_outside_the_folder_are_refused(colmap):
    Image.new("RGB", SIZE[::-1]).save(colmap / "0.jpg")
    spoil(colmap / "images.txt", "walk/0.jpg", "../0.jpg")
    with pytest.raises(SequenceError, match="leaves the folder"):
        read_sequence(colmap)


def test_names_of_other_digits_are_none_of_a_scans(scannet):
    save_picture(scannet / "color/².jpg", 10)
    assert len(read_sequence(scannet).frames) == len(EYES)


@pytest.mark.parametrize("spoiled", ["cut", "checksum", "colour"])
def test_damaged_depth_pictures_are_named(tum, spoiled):
    frame = read_sequence(tum).frames[0]
    path = frame.depth.path
    data = path.read_bytes()
    if spoiled == "colour":
        save_picture(path, 10)
    else:
        at = data.index(b"IDAT") + 10
        path.write_bytes(data[:at] if spoiled == "cut" else data[:at] + b"xyz" + data[at + 3 :])
    with pytest.raises(SequenceError, match=path.name):
        frame.depth.read()


def test_depth_of_record3d_that_unpacks_to_more_than_its_picture_is_refused(record3d):
    codecs = pytest.importorskip("imagecodecs", reason="it packs LZFSE")
    (record3d / "rgbd/0.depth").write_bytes(codecs.lzfse_encode(bytes(10**7)))
    with pytest.raises(SequenceError, match=r"0\.depth: not readable \(it unpacks to more than"):
        read_sequence(record3d).frames[0].depth.read()
