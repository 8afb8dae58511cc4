"""Labels on Ray: two workers, one of which is killed on the way."""

import importlib
import os
import signal
import threading
import time
from collections import Counter
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from ray_cluster import two_workers

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.parallel.on_ray import run_on_ray
from footprints_edge_models.sequences.sequence import DepthPicture, Sequence, SequenceFrame
from footprints_edge_models.video_labels.files import read_frame
from footprints_edge_models.video_labels.job import LabelJob, make_labels
from footprints_edge_models.video_labels.labeller import LabelSettings

ray = pytest.importorskip("ray", reason="Ray is an extra: pip install 'footprints-edge[ray]'")


HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def scripts():
    """The module of stand-ins."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(HERE)
        yield importlib.import_module("scripted_labels")


@pytest.fixture(scope="module")
def cluster():
    """Two worker processes on this machine, which find the stand-ins too."""
    with two_workers(HERE):
        yield


def job_of(folder, script, count):
    camera, missing = Intrinsics(20.0, 20.0, 7.5, 5.5), Path("nowhere")
    frames = [
        SequenceFrame(f"{i:03d}", i, missing, camera, np.eye(4), DepthPicture(missing))
        for i in range(count)
    ]
    return LabelJob(Sequence("made", tuple(frames)), LabelSettings(), folder, script)


def run(job):
    outcomes = []
    make_labels(job, partial(run_on_ray, workers=2, run_length=8), outcomes.append)
    assert sorted(o.name for o in outcomes) == [frame.name for frame in job.sequence.frames]
    return {outcome.name: outcome for outcome in outcomes}


@pytest.mark.usefixtures("cluster")
def test_a_killed_worker_loses_nothing_and_repeats_no_finished_frame(tmp_path, scripts):
    script = scripts.Scripted(tmp_path / "log", pause_s=0.1)
    job = job_of(tmp_path / "labels", script, count=30)
    killed = {}

    def kill_one():
        while len(list(job.folder.rglob("*.npz"))) < 5:
            time.sleep(0.01)
        killed["finished"] = {path.stem for path in job.folder.rglob("*.npz")}
        killed["frame"], killed["pid"] = script.computed()[-1]
        os.kill(killed["pid"], signal.SIGKILL)

    killer = threading.Thread(target=kill_one, daemon=True)
    killer.start()
    outcomes = run(job)
    killer.join(10)
    assert "pid" in killed, outcomes

    assert Counter(outcome.state for outcome in outcomes.values()) == {"done": 30}
    computed = script.computed()
    assert len({pid for _, pid in computed}) >= 2
    times = Counter(name for name, _ in computed)
    # Nothing is lost ...
    for index, frame in enumerate(job.sequence.frames):
        assert read_frame(job.folder, frame.name).visible_depth_m[0, 0] == 3.0 + index
    # ... what had its file before the kill was computed exactly once, and only the one frame that
    # the killed worker was at, which had none, was begun twice.
    assert all(times[name] == 1 for name in killed["finished"])
    assert {name for name, count in times.items() if count > 1} <= {killed["frame"]}
    assert times[killed["frame"]] <= 2
    assert [path for path in job.folder.rglob("*") if path.name.endswith(".part")] == []

    again = run(job)
    assert Counter(outcome.state for outcome in again.values()) == {"kept": 30}
    assert len(script.computed()) == len(computed)


@pytest.mark.usefixtures("cluster")
def test_a_frame_that_always_kills_its_worker_costs_only_itself(tmp_path, scripts):
    script = scripts.Scripted(tmp_path / "log", dies_at=("003",), fails_at=("005",))
    outcomes = run(job_of(tmp_path / "labels", script, count=8))
    assert Counter(outcome.state for outcome in outcomes.values()) == {"done": 6, "failed": 2}
    assert "WorkerCrashedError" in outcomes["003"].reason
    assert outcomes["005"].reason == "005.png: no such file"
    times = Counter(name for name, _ in script.computed())
    assert all(times[name] == 1 for name in outcomes if outcomes[name].state == "done")
