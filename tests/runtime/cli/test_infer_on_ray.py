"""Pictures on Ray: two workers, one of which is killed on the way."""

import os
import signal
import sys
import threading
import time
from collections import Counter

import numpy as np
import pytest
from PIL import Image
from ray_cluster import two_workers

from footprints_edge.cli.batch import plan
from footprints_edge.cli.exit_codes import OptionError
from footprints_edge.cli.infer_on_ray import infer_on_ray
from footprints_edge.cli.run_infer import run_infer

pytest.importorskip("ray", reason="Ray is an extra: pip install 'footprints-edge[ray]'")


@pytest.fixture(scope="module")
def cluster():
    """Two worker processes on this machine."""
    with two_workers():
        yield


def photos(folder, count):
    folder.mkdir()
    rng = np.random.default_rng(0)
    for number in range(count):
        pixels = rng.integers(0, 255, (64, 96, 3), np.uint8)
        Image.fromarray(pixels).save(folder / f"{number:02d}.png")
    return folder


@pytest.mark.usefixtures("cluster")
def test_a_killed_worker_loses_nothing_and_writes_nothing_twice(tiny_path, tmp_path, capsys):
    folder, out, log = photos(tmp_path / "in", 24), tmp_path / "out", tmp_path / "log"
    log.mkdir()

    def slow(prediction):  # leaves a file: which process worked on which picture
        (log / f"{prediction.name} {os.getpid()} {time.monotonic_ns()}").touch()
        time.sleep(0.1)
        return b"made"

    def tasks():
        how = {"recursive": False, "overwrite": False, "extra": {".made": slow}}
        return plan([str(folder)], ["json"], out, **how)

    killed = {}

    def kill_one():
        while len(done := list(out.glob("*.made"))) < 4:
            time.sleep(0.01)
        killed["finished"] = {path.name.removesuffix(".made") for path in done}
        killed["pid"] = int(
            max(log.iterdir(), key=lambda p: int(p.name.split()[2])).name.split()[1]
        )
        os.kill(killed["pid"], signal.SIGKILL)

    killer = threading.Thread(target=kill_one, daemon=True)
    killer.start()
    batch = tasks()
    infer_on_ray(batch, str(tiny_path), {}, workers=2, quiet=True, verbose=False)
    killer.join(10)
    assert "pid" in killed
    assert batch.failures == []
    named = [f"{number:02d}.png" for number in range(24)]
    ends = (".json", ".made")
    assert capsys.readouterr().out.split() == [str(out / (n + end)) for n in named for end in ends]
    assert sorted(path.name for path in out.iterdir()) == sorted(n + e for n in named for e in ends)
    times = Counter(path.name.split()[0] for path in log.iterdir())
    assert all(times[name] == 1 for name in killed["finished"])
    assert sum(times.values()) <= 25  # only what the killed worker was at is begun twice
    assert tasks().tasks == []


@pytest.mark.usefixtures("cluster")
def test_results_are_those_of_this_machine_and_replace_older_ones(tiny_path, tmp_path, capsys):
    folder = photos(tmp_path / "in", 3)
    (folder / "broken.jpg").write_bytes(b"no picture")
    common = {"formats": ["npz"], "model": str(tiny_path), "hfov": 60, "quiet": True}
    for out, engine in (("here", "onnxruntime"), ("ray", "ray")):
        (tmp_path / out).mkdir()
        (tmp_path / out / "00.png.npz").write_bytes(b"old")
        with pytest.raises(SystemExit) as ended:
            run_infer([str(folder)], output=tmp_path / out, engine=engine, overwrite=True, **common)
        assert ended.value.code == 1
        assert "broken.jpg" in capsys.readouterr().err
    for number in range(3):
        name = f"{number:02d}.png.npz"
        with np.load(tmp_path / "here" / name) as here, np.load(tmp_path / "ray" / name) as there:
            assert all(np.array_equal(here[key], there[key], equal_nan=True) for key in here)


def test_what_is_no_file_of_a_picture_is_refused():
    for named in ("-", "walk.mp4"):
        with pytest.raises(OptionError, match="--engine ray"):
            run_infer([named], engine="ray")


def test_a_missing_ray_is_said_at_once(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(OptionError, match=r"pip install .*\[ray\]"):
        run_infer([str(photos(tmp_path / "in", 1))], engine="ray")
