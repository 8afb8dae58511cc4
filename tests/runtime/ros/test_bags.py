"""`fp-infer` on bags: what is read, what is written, and what happens with damaged ones."""

import io
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("rosbags")
pytest.importorskip("cv2")

from bags import (
    FRAME,
    SIZE,
    START_NS,
    STEP_NS,
    K,
    Messages,
    drive,
    mcap_file,
    picture,
    stamp_of,
    write_bag,
)
from rosbags.highlevel import AnyReader
from typer.testing import CliRunner

from footprints_edge.cli.infer import app
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.ros.ground_messages import TOPICS, grid_message
from footprints_edge.ros.messages import Header, Time

CAMERA = Intrinsics(K[0], K[4], K[2], K[5])


@pytest.fixture
def infer(tiny_path):
    def invoke(*arguments):
        options = ["--model", str(tiny_path), "--threads", "2"]
        return CliRunner().invoke(app, [*map(str, arguments), *options])

    return invoke


def read(path):
    """By topic, (nanoseconds, message) in order: read by rosbags."""
    found = {}
    with AnyReader([path]) as reader:
        for connection, logged_ns, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((logged_ns, message))
    return found


def read_by_the_other(path):
    """The same, read by mcap-ros2-support."""
    reader = pytest.importorskip("mcap_ros2.reader")
    found = {}
    for each in reader.read_ros2_messages(str(path)):
        found.setdefault(each.channel.topic, []).append((each.log_time_ns, each.ros_msg))
    return found


def stamps(messages):
    return [(m.header.stamp.sec, m.header.stamp.nanosec) for _, m in messages]


@pytest.fixture
def bag(tmp_path):
    return mcap_file(tmp_path, drive())


@pytest.mark.parametrize("read_back", [read, read_by_the_other])
def test_a_bag_gives_grids_with_its_stamps_equal_to_those_of_the_interface(
    infer, bag, tiny, read_back
):
    out = bag.with_name("out.mcap")
    result = infer(bag, "-o", out)
    assert result.exit_code == 0, result.output
    assert result.stdout.split() == [str(out)]
    got = read_back(out)
    assert set(got) == {TOPICS[key] for key in ("tf", "grid", "scan", "points", "overlay")}
    expected = [stamp_of(index) for index in range(3)]
    for key in ("grid", "scan", "points", "overlay"):
        assert stamps(got[TOPICS[key]]) == expected
        assert [ns for ns, _ in got[TOPICS[key]]] == [
            START_NS + index * STEP_NS + 5_000_000 for index in range(3)
        ]
    for index, (_, grid) in enumerate(got[TOPICS["grid"]]):
        prediction = tiny.predict(picture(index), intrinsics=CAMERA)
        header = Header(Time(*stamp_of(index)), "camera_footprint")
        wanted = grid_message(prediction.top_down(), header)
        assert grid.header.frame_id == "camera_footprint"
        np.testing.assert_array_equal(np.array(grid.data, np.int8), wanted.data)
        assert {0, 50, -1} <= set(np.unique(wanted.data))
        info = grid.info
        assert (info.width, info.height) == (wanted.info.width, wanted.info.height)
        assert info.origin.position.y == pytest.approx(-10)
    ranges = prediction.scan().ranges_m
    np.testing.assert_array_equal(np.array(got[TOPICS["scan"]][-1][1].ranges, np.float32), ranges)
    overlay = Image.open(io.BytesIO(bytes(got[TOPICS["overlay"]][0][1].data)))
    assert overlay.size[0] >= SIZE[1] and overlay.size[1] > SIZE[0]
    transform = got["/tf"][0][1].transforms[0]
    assert (transform.header.frame_id, transform.child_frame_id) == (FRAME, "camera_footprint")
    first = tiny.predict(picture(0), intrinsics=CAMERA).ground_plane()
    t = transform.transform.translation
    assert np.linalg.norm([t.x, t.y, t.z]) == pytest.approx(first.camera_height_m)


@pytest.mark.parametrize("kind", ["sqlite3", "file in a folder", "ros1"])
def test_other_kinds_of_bags_give_the_same(infer, bag, tmp_path, kind):
    ros = 1 if kind == "ros1" else 2
    other = write_bag(tmp_path / ("other.bag" if ros == 1 else "other"), drive(ros=ros), ros)
    if kind == "file in a folder":
        other = other / "other.db3"
    for source, name in ((bag, "a.mcap"), (other, "b.mcap")):
        result = infer(source, "-o", tmp_path / name)
        assert result.exit_code == 0, result.output
    one, two = read(tmp_path / "a.mcap"), read(tmp_path / "b.mcap")
    assert set(one) == set(two)
    for topic in set(one) - {"/tf"}:
        assert stamps(one[topic]) == stamps(two[topic])
    for (_, a), (_, b) in zip(one[TOPICS["grid"]], two[TOPICS["grid"]], strict=True):
        np.testing.assert_array_equal(a.data, b.data)


def test_a_bag_of_ros_1_is_written_for_ros_1(infer, tmp_path):
    source = write_bag(tmp_path / "drive.bag", drive(ros=1), ros=1)
    result = infer(source)
    assert result.exit_code == 0, result.output
    out = tmp_path / "drive.bag.ground.bag"
    assert result.stdout.split() == [str(out)]
    got = read(out)
    assert stamps(got[TOPICS["grid"]]) == [stamp_of(index) for index in range(3)]
    (transform,) = got["/tf"][0][1].transforms
    assert transform.child_frame_id == "camera_footprint"


def test_options_of_the_camera_come_before_its_info_and_a_known_pose_is_static(infer, bag, tiny):
    out = bag.with_name("out.mcap")
    pose = ("--camera-height", "0.8", "--pitch", "10", "--roll", "2")
    result = infer(bag, "-o", out, "--hfov", "70", *pose, "--hidden", "unknown")
    assert result.exit_code == 0, result.output
    got = read(out)
    assert len(got["/tf_static"]) == 1 and "/tf" not in got
    prediction = tiny.predict(
        picture(1),
        intrinsics=Intrinsics.from_hfov(70, SIZE),
        camera_height_m=0.8,
        pitch_deg=10,
        roll_deg=2,
    )
    wanted = grid_message(prediction.top_down(), Header(Time(0, 0), ""), "unknown")
    np.testing.assert_array_equal(got[TOPICS["grid"]][1][1].data, wanted.data)
    assert 50 not in wanted.data


def test_distortion_is_rectified_and_the_ground_is_that_of_the_rectified_picture(
    infer, tmp_path, tiny
):
    from footprints_edge.inputs.calibration import Calibration

    d = (-0.2, 0.05, 0, 0, 0)
    messages = Messages(2)
    items = [("/image", 5, messages.image(0)), ("/camera_info", 5, messages.camera_info(0, d=d))]
    out = tmp_path / "out.mcap"
    assert infer(mcap_file(tmp_path, items), "-o", out).exit_code == 0
    lens = Calibration.of(SIZE, np.array(K), "plumb_bob", np.array(d))
    prediction = tiny.predict(picture(0), intrinsics=lens)
    assert prediction.intrinsics.source == "rectified"
    wanted = grid_message(prediction.top_down(), Header(Time(0, 0), ""))
    np.testing.assert_array_equal(read(out)[TOPICS["grid"]][0][1].data, wanted.data)


@pytest.mark.parametrize("info_first", [True, False])
def test_each_picture_of_a_lens_that_zooms_has_its_own_camera(infer, tmp_path, tiny, info_first):
    messages = Messages(2)
    focal = [60.0, 75, 90]
    items = []
    for index, f in enumerate(focal):
        info = messages.camera_info(index, k=(f, 0, K[2], 0, f, K[5], 0, 0, 1))
        pair = [("/image", messages.image(index)), ("/camera_info", info)]
        for topic, message in pair[:: -1 if info_first else 1]:
            items.append((topic, START_NS + len(items) * 1000, message))
    out = tmp_path / "out.mcap"
    assert infer(mcap_file(tmp_path, items), "-o", out).exit_code == 0
    grids = read(out)[TOPICS["grid"]]
    for index, f in enumerate(focal):
        prediction = tiny.predict(picture(index), intrinsics=Intrinsics(f, f, K[2], K[5]))
        wanted = grid_message(prediction.top_down(), Header(Time(0, 0), ""))
        np.testing.assert_array_equal(grids[index][1].data, wanted.data)


def test_a_bad_message_is_named_and_the_others_are_done(infer, tmp_path):
    messages = Messages(2)
    items = list(drive(6))
    items[2] = (*items[2][:2], messages.image(1, encoding="nv99"))
    items[4] = (*items[4][:2], (b"\x00\x01\x00\x00junk", "sensor_msgs/msg/Image"))
    items[6] = (*items[6][:2], messages.image(3, picture(3, (48, 48))))
    out = tmp_path / "out.mcap"
    result = infer(mcap_file(tmp_path, items), "-o", out)
    assert result.exit_code == 0, result.output
    assert "/front/image_raw, message 1, stamp 1700000000.223456796: its encoding" in result.stderr
    assert "message 2, " in result.stderr
    assert "message 3, " in result.stderr and "48 x 48" in result.stderr
    assert "3 broken" in result.stderr
    assert stamps(read(out)[TOPICS["grid"]]) == [stamp_of(index) for index in (0, 4, 5)]


def test_a_bag_that_breaks_off_gives_what_came_before_and_says_so(infer, tmp_path):
    whole = mcap_file(tmp_path, drive(40))
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[: whole.stat().st_size * 2 // 3])
    result = infer(cut, "-o", tmp_path / "out.mcap")
    assert "cut.mcap" in result.stderr
    assert "Traceback" not in result.output
    if result.exit_code == 0:
        assert "cannot be read further" in result.stderr
        assert len(read(tmp_path / "out.mcap")[TOPICS["grid"]]) > 5
    else:
        assert not (tmp_path / "out.mcap").exists()


@pytest.mark.parametrize(
    ("content", "reason"), [(b"", "cannot be read as a bag"), (b"no bag" * 99, "cannot be read")]
)
@pytest.mark.parametrize("name", ["a.mcap", "a.bag", "a.db3"])
def test_other_files_are_refused(infer, tmp_path, name, content, reason):
    (tmp_path / name).write_bytes(content)
    result = infer(tmp_path / name)
    assert result.exit_code == 1
    assert reason in result.stderr or "no pictures" in result.stderr
    assert sorted(each.name for each in tmp_path.iterdir()) == [name]


def test_one_bag_that_fails_does_not_stop_the_others(infer, bag, tmp_path):
    result = infer(tmp_path / "none.mcap", bag, "-o", tmp_path / "out")
    assert result.exit_code == 1
    assert "none.mcap: no such file" in result.stderr
    assert (tmp_path / "out" / "drive.mcap.ground.mcap").is_file()


def test_results_are_kept_unless_overwrite_is_given(infer, bag):
    out = bag.with_name("out.mcap")
    out.write_bytes(b"mine")
    kept = infer(bag, "-o", out)
    assert kept.exit_code == 0 and "--overwrite" in kept.stderr
    assert out.read_bytes() == b"mine"
    assert infer(bag, "-o", out, "--overwrite").exit_code == 0
    assert len(read(out)[TOPICS["grid"]]) == 3
    refused = infer(bag, "-o", bag, "--overwrite")
    assert refused.exit_code == 1 and len(read(bag)["/front/image_raw"]) == 3


@pytest.mark.parametrize(
    ("topic", "index"), [("/left/image_raw", 0), ("right/image_raw/compressed", 1)]
)
def test_topic_chooses_the_camera(infer, tmp_path, topic, index):
    messages = Messages(2)
    buffer = io.BytesIO()
    Image.fromarray(picture(1)).save(buffer, "PNG")
    items = [
        ("/left/image_raw", 5, messages.image(0)),
        ("/left/camera_info", 5, messages.camera_info(0)),
        ("/right/image_raw/compressed", 6, messages.compressed(1, buffer.getvalue(), "png")),
        ("/right/camera_info", 6, messages.camera_info(1)),
    ]
    source = mcap_file(tmp_path, items)
    several = infer(source)
    assert several.exit_code == 1
    assert "give --topic, one of /left/image_raw, /right/image_raw/compressed" in several.stderr
    assert "is sensor_msgs/msg/CameraInfo" in infer(source, "--topic", "/left/camera_info").stderr
    assert "is not in it" in infer(source, "--topic", "/up/image_raw").stderr
    out = tmp_path / "out.mcap"
    result = infer(source, "-o", out, "--topic", topic)
    assert result.exit_code == 0, result.output
    assert "Assumed" not in result.stderr  # its camera_info was found
    assert stamps(read(out)[TOPICS["grid"]]) == [stamp_of(index)]


def test_the_compressed_topic_of_the_same_camera_is_no_other_camera(infer, tmp_path):
    messages = Messages(2)
    items = [
        *drive(2),
        ("/front/image_raw/compressed", START_NS, messages.compressed(0, b"", "jpeg")),
    ]
    assert infer(mcap_file(tmp_path, items)).exit_code == 0


def test_a_bag_without_camera_info_says_so_and_that_the_lens_is_assumed(infer, tmp_path):
    result = infer(mcap_file(tmp_path, drive(2, info=None)))
    assert result.exit_code == 0
    assert "no camera_info beside /front/image_raw" in result.stderr
    assert "Assumed a lens" in result.stderr


def test_a_bag_without_pictures_names_its_topics(infer, tmp_path):
    items = [("/front/camera_info", 5, Messages(2).camera_info(0))]
    result = infer(mcap_file(tmp_path, items))
    assert result.exit_code == 1
    assert "no pictures" in result.stderr and "/front/camera_info" in result.stderr


def test_every_and_format_leave_the_others_out(infer, bag):
    out = bag.with_name("out.mcap")
    assert infer(bag, "-o", out, "--every", "2", "--format", "grid").exit_code == 0
    got = read(out)
    assert set(got) == {"/tf", TOPICS["grid"]}
    assert stamps(got[TOPICS["grid"]]) == [stamp_of(index) for index in (0, 2)]


@pytest.mark.parametrize(
    "wrong",
    [
        ["--format", "npz"],
        ["--hidden", "maybe"],
        ["--path", "1,1", "2,2"],
        ["--ground-frame", ""],
    ],
)
def test_options_that_do_not_fit_are_refused(infer, bag, wrong):
    assert infer(bag, *wrong).exit_code == 2


def test_an_output_file_is_for_one_bag(infer, bag, clip):
    assert infer(bag, clip, "-o", bag.with_name("out.mcap")).exit_code == 2
    assert infer(clip, "--topic", "/a").exit_code == 2


def test_without_rosbags_the_message_says_what_to_install(infer, bag, monkeypatch):
    for name in [each for each in sys.modules if each.split(".")[0] == "rosbags"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "rosbags", None)
    result = infer(bag)
    assert result.exit_code == 1
    assert "footprints-edge[ros]" in result.stderr


def under_way(folder, out, model):
    """A process that has begun to write the bag `out` beside its source."""
    source = mcap_file(folder, drive(150))
    command = [sys.executable, "-m", "footprints_edge", source, "-o", out, "--model", model]
    process = subprocess.Popen([*map(str, command), "--threads", "1"], stdout=subprocess.PIPE)
    deadline = time.monotonic() + 60
    while not any(file.stat().st_size > 10_000 for file in folder.glob(".fp-*.part/bag/*")):
        assert time.monotonic() < deadline and process.poll() is None
        time.sleep(0.02)
    assert not out.exists()
    return process


def test_ctrl_c_leaves_a_readable_part_under_another_name(tiny_path, tmp_path):
    (tmp_path / "out.partial").mkdir()  # somebody's own
    out = tmp_path / "out.mcap"
    process = under_way(tmp_path, out, tiny_path)
    os.kill(process.pid, signal.SIGINT)
    stdout, _ = process.communicate(timeout=30)
    assert process.returncode == 130
    part = tmp_path / "out.partial.mcap"
    assert stdout.decode().split() == [str(part)]
    assert not out.exists() and (tmp_path / "out.partial").is_dir()
    assert not list(tmp_path.glob(".*"))
    got = stamps(read(part)[TOPICS["grid"]])
    assert got == [stamp_of(index) for index in range(len(got))] and got


def test_the_next_bag_removes_what_a_killed_run_left(infer, tiny_path, tmp_path):
    (tmp_path / "short").mkdir()
    bag = mcap_file(tmp_path / "short", drive(2))
    process = under_way(tmp_path, tmp_path / "out.mcap", tiny_path)
    process.kill()
    process.communicate()
    assert len(list(tmp_path.glob(".*"))) == 1
    assert infer(bag, "-o", tmp_path / "other.mcap").exit_code == 0
    assert not list(tmp_path.glob(".*"))
