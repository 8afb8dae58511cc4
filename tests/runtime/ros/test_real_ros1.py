"""A written bag on a real ROS 1: master, publisher and subscriber of Debian's packages.

`apt-get install python3-rospy python3-rosmaster python3-rosbag python3-nav-msgs`
"""

import hashlib
import os
import shutil
import socket
import subprocess
from pathlib import Path

import pytest
from typer.testing import CliRunner

pytest.importorskip("rosbags")
pytest.importorskip("cv2")

from bags import K, drive, picture, stamp_of, write_bag

from footprints_edge.cli.infer import app
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.ros.ground_messages import TOPICS, grid_message
from footprints_edge.ros.messages import Header, Time

PYTHON = "/usr/bin/python3"
SCRIPT = Path(__file__).resolve().parents[2] / "support" / "ros1_listener.py"
NEEDED = "import rospy, rosbag, rosmaster, nav_msgs.msg"


@pytest.fixture
def ros(tmp_path):
    """The environment of a running master."""
    here = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    if not (
        Path(PYTHON).exists()
        and shutil.which("rosmaster")
        and subprocess.run(
            [PYTHON, "-c", NEEDED], env=here, capture_output=True, check=False
        ).returncode
        == 0
    ):
        pytest.skip("Debian's packages of ROS 1 are not installed")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    here |= {
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(tmp_path),
    }
    master = subprocess.Popen(
        [PYTHON, shutil.which("rosmaster"), "--core", "-p", str(port)],
        env=here,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    yield here
    master.terminate()
    master.wait(10)


def test_a_subscriber_gets_the_grids_of_the_interface(ros, tiny, tiny_path, tmp_path):
    source = write_bag(tmp_path / "drive.bag", drive(ros=1), ros=1)
    out, topic = tmp_path / "out.bag", TOPICS["grid"]
    result = CliRunner().invoke(app, [str(source), "-o", str(out), "--model", str(tiny_path)])
    assert result.exit_code == 0, result.output
    listener = subprocess.Popen(
        [PYTHON, SCRIPT, "listen", "3", topic], env=ros, stdout=subprocess.PIPE, text=True
    )
    subprocess.run([PYTHON, SCRIPT, "play", out, topic], env=ros, check=True, timeout=60)
    lines, _ = listener.communicate(timeout=60)
    got = [line.split() for line in lines.splitlines()]
    assert [(int(sec), int(nanosec)) for sec, nanosec, *_ in got] == list(map(stamp_of, range(3)))
    for index, (*_, frame, width, cells) in enumerate(got):
        prediction = tiny.predict(picture(index), intrinsics=Intrinsics(K[0], K[4], K[2], K[5]))
        assert (frame, int(width)) == ("camera_footprint", 200)
        wanted = grid_message(prediction.top_down(), Header(Time(0, 0), "")).data
        assert cells == hashlib.sha256(wanted.tobytes()).hexdigest()
