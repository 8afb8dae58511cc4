"""The node of `examples/ros2`, with a stand-in for rclpy: ROS is not here."""

import math
import runpy
from array import array
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rosbags")

import ros2_stand_in
from bags import K, Messages, picture, stamp_of

import footprints_edge as fp
from footprints_edge.ros.ground_messages import TOPICS, grid_message, scan_message
from footprints_edge.ros.messages import Header, Time

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "ros2"


@pytest.fixture
def node(monkeypatch, tiny):
    """A function that starts the node with some parameters."""
    get_message = ros2_stand_in.install(monkeypatch)
    monkeypatch.setattr(fp, "load", lambda **_: tiny)  # of the bundled model, another
    loaded = runpy.run_path(str(EXAMPLE / "footprints_node.py"))

    def start(**parameters):
        monkeypatch.setattr(ros2_stand_in.Node, "parameters", parameters)
        return loaded["Footprints"]()

    start.get_message = get_message
    return start


def as_rclpy(message, get_message):
    """A message of rosbags as one of rclpy."""
    if isinstance(message, np.ndarray):
        return array(message.dtype.char, message.tobytes())
    if not hasattr(message, "__msgtype__"):
        return message
    parts = {
        field.name: as_rclpy(getattr(message, field.name), get_message)
        for field in fields(message)
        if "ClassVar" not in str(field.type)
    }
    return get_message(message.__msgtype__)(**parts)


def send(node, topic, message, get_message):
    kind, callback, _ = node.subscriptions[topic]
    sent = as_rclpy(message, get_message)
    assert isinstance(sent, kind)
    callback(sent)


def test_a_picture_gives_the_messages_of_the_interface(node, tiny):
    started = node()
    send(started, "camera_info", Messages(2).camera_info(4), node.get_message)
    send(started, "image", Messages(2).image(4), node.get_message)
    assert started.warnings == []
    sent = {topic: publisher.sent for topic, publisher in started.publishers.items()}
    assert [len(sent[TOPICS[key]]) for key in ("tf", "tf_static", "grid", "scan", "points")] == [
        1, 0, 1, 1, 1,
    ]  # fmt: skip
    (grid,) = sent[TOPICS["grid"]]
    prediction = tiny.predict(picture(4), intrinsics=fp.Intrinsics(K[0], K[4], K[2], K[5]))
    wanted = grid_message(prediction.top_down(), Header(Time(*stamp_of(4)), "camera_footprint"))
    assert grid.data.tolist() == wanted.data.tolist()
    assert (grid.header.stamp.sec, grid.header.stamp.nanosec) == stamp_of(4)
    assert grid.header.frame_id == "camera_footprint"


def test_parameters_give_the_pose_and_the_frame(node):
    started = node(camera_height_m=0.9, pitch_deg=5.0, roll_deg=0.0, ground_frame="base_footprint")
    send(started, "image", Messages(2).image(0), node.get_message)
    latched = started.publishers["/tf_static"]
    (transform,) = latched.sent[0].transforms
    assert latched.qos.durability == "transient local"
    assert transform.child_frame_id == "base_footprint"
    t = transform.transform.translation
    assert math.hypot(t.x, t.y, t.z) == pytest.approx(0.9)


def test_the_height_of_the_robot_decides_what_is_an_obstacle(node, tiny):
    camera = fp.Intrinsics(K[0], K[4], K[2], K[5])
    scans = []
    for height_m in (0.3, 2.0):
        started = node(robot_height_m=height_m)
        send(started, "camera_info", Messages(2).camera_info(4), node.get_message)
        send(started, "image", Messages(2).image(4), node.get_message)
        (scan,) = started.publishers[TOPICS["scan"]].sent
        prediction = tiny.predict(picture(4), intrinsics=camera, robot_height_m=height_m)
        wanted = scan_message(prediction.scan(np.arange(-90.0, 91.0)), Header(Time(0, 0), ""))
        assert np.array_equal(scan.ranges, wanted.ranges, equal_nan=True)
        scans.append(scan.ranges)
    assert not np.array_equal(*scans, equal_nan=True)


def test_a_bad_message_is_said_and_the_next_one_is_done(node):
    started = node()
    info = Messages(2).camera_info(0, d=(1.0, 2.0))
    send(started, "camera_info", info, node.get_message)
    send(started, "image", Messages(2).image(0, encoding="nv99"), node.get_message)
    assert ["coefficients" in started.warnings[0][0], "nv99" in started.warnings[2][0]] == [1, 1]
    assert "the lens is assumed" in started.warnings[1][0]
    send(started, "image", Messages(2).image(1), node.get_message)
    assert len(started.publishers[TOPICS["points"]].sent) == 1


def test_the_node_fits_on_a_screen():
    code = (EXAMPLE / "footprints_node.py").read_text().splitlines()
    assert len(code) <= 110


def test_the_launch_file_starts_the_node_with_its_own_parameters(monkeypatch):
    ros2_stand_in.install(monkeypatch)
    described = runpy.run_path(str(EXAMPLE / "footprints.launch.py"))
    (actions,) = described["generate_launch_description"]().given
    started = next(a for a in actions if "footprints_node.py" in str(a.named.get("cmd")))
    command = started.named["cmd"]
    given = [(flag, words[0]) for flag, words in zip(command[3::2], command[4::2], strict=True)]
    declared = {"camera_height_m", "pitch_deg", "roll_deg", "robot_height_m", "ground_frame"}
    declared |= {"hidden", "rectified"}
    assert {name for flag, name in given if flag == "-p"} == declared
    assert {name for flag, name in given if flag == "-r"} == {"image", "camera_info"}


def test_rviz_shows_the_topics_that_are_published():
    text = (EXAMPLE / "footprints.rviz").read_text()
    for key in ("grid", "scan", "points"):
        assert f"Value: {TOPICS[key]}\n" in text
    assert "Fixed Frame: camera_footprint" in text
