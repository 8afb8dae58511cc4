"""Labels of a whole sequence: what is written, what a second run does, what a failure costs."""

import importlib
import json
import multiprocessing
import os
import shutil
import signal
import time
from collections import Counter
from dataclasses import replace
from functools import partial
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from footprints_edge.errors import FootprintsError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.parallel.processes import run_in_processes
from footprints_edge_models.cli import app
from footprints_edge_models.data.mixture import load_datasets
from footprints_edge_models.data.readers.video_labels import read_video_labels
from footprints_edge_models.sample import NO, UNSEEN, YES
from footprints_edge_models.sequences.sequence import DepthPicture, InTime, Sequence, SequenceFrame
from footprints_edge_models.video_labels.contact_sheet import WIDTH_PX, draw_contact_sheet
from footprints_edge_models.video_labels.files import LabelFilesError, claim, frame_path, read_frame
from footprints_edge_models.video_labels.job import LabelJob, hidden_share, make_labels
from footprints_edge_models.video_labels.labeller import LabelSettings


@pytest.fixture(scope="module")
def scripts():
    """The module of stand-ins, where worker processes find it too."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(Path(__file__).parent)
        yield importlib.import_module("scripted_labels")


def sequence_of(count):
    camera = Intrinsics(20.0, 20.0, 7.5, 5.5)
    missing = Path("nowhere")
    names = [f"left/{i:03d}" for i in range(count)]
    frames = [
        SequenceFrame(name, i, missing, camera, np.eye(4), DepthPicture(missing))
        for i, name in enumerate(names)
    ]
    return Sequence("made", tuple(frames))


def job_of(folder, script, count=6):
    return LabelJob(sequence_of(count), LabelSettings(size=(12, 16)), folder, script)


def run(job, processes=2):
    outcomes = []
    make_labels(job, partial(run_in_processes, processes=processes), outcomes.append)
    assert sorted(o.name for o in outcomes) == [frame.name for frame in job.sequence.frames]
    return {outcome.name: outcome for outcome in outcomes}


def states(outcomes):
    return Counter(outcome.state for outcome in outcomes.values())


@pytest.fixture(scope="module")
def run_once(scripts, tmp_path_factory):
    """The folder of a job that is done, and its outcomes."""
    folder = tmp_path_factory.mktemp("finished")
    return folder, run(job_of(folder / "labels", scripts.Scripted(folder / "log")))


@pytest.fixture
def finished(tmp_path, scripts, run_once):
    """A job that is done, and the script that it ran: a copy, for each test to spoil."""
    folder, outcomes = run_once
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    script = scripts.Scripted(tmp_path / "log")
    return job_of(tmp_path / "labels", script), script, outcomes


def test_every_frame_is_labelled_once_and_reads_back(finished, scripts):
    job, script, outcomes = finished
    assert states(outcomes) == {"done": 6}
    assert Counter(name for name, _ in script.computed()) == Counter(list(outcomes))
    for index, frame in enumerate(job.sequence.frames):
        made, read = scripts.labels_of(frame.name, index), read_frame(job.folder, frame.name)
        assert read.name == made.name
        assert read.intrinsics == made.intrinsics
        np.testing.assert_allclose(read.image, made.image, atol=2)
        for field in ("ground_probability", "visible_depth_m", "ground_depth_m"):
            values = getattr(read, field)
            assert values.dtype == np.float32
            np.testing.assert_allclose(values, getattr(made, field), rtol=5e-4)
        np.testing.assert_array_equal(read.footprint_mask, made.footprint_mask)
        np.testing.assert_array_equal(read.moving, made.moving)
    # Half of the labelled ground is not seen in the frame itself.
    assert hidden_share(outcomes.values()) == 0.5


def test_workers_take_contiguous_parts(finished):
    _, script, _ = finished
    by_worker = {}
    for name, pid in script.computed():
        by_worker.setdefault(pid, []).append(int(name[-3:]))
    assert sorted(by_worker.values()) == [[0, 1, 2], [3, 4, 5]]


def test_a_second_run_computes_nothing_and_counts_the_same(finished):
    job, script, outcomes = finished
    before = {path: path.stat().st_mtime_ns for path in job.folder.rglob("*")}
    again = run(job)
    assert states(again) == {"kept": 6}
    assert len(script.computed()) == 6
    assert hidden_share(again.values()) == hidden_share(outcomes.values())
    assert {path: path.stat().st_mtime_ns for path in job.folder.rglob("*")} == before


def test_what_is_missing_or_damaged_is_made_again(finished):
    job, script, _ = finished
    frame_path(job.folder, "left/001").unlink()
    damaged = frame_path(job.folder, "left/004")
    data = bytearray(damaged.read_bytes())
    data[len(data) // 2] ^= 0xFF
    damaged.write_bytes(data)
    truncated = frame_path(job.folder, "left/005")
    truncated.write_bytes(truncated.read_bytes()[:-100])
    again = run(job)
    assert states(again) == {"kept": 3, "done": 3}
    computed = Counter(name for name, _ in script.computed())
    assert {name for name, times in computed.items() if times == 2} == {
        "left/001", "left/004", "left/005"
    }  # fmt: skip
    assert read_frame(job.folder, "left/004").visible_depth_m[0, 0] == 7.0


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"settings": LabelSettings(size=(6, 8))}, r"settings.size = \[12, 16\]"),
        ({"settings": LabelSettings(size=(12, 16), ground="depth")}, "settings.ground"),
        ({"sequence": replace(sequence_of(6), name="other")}, 'sequence = "made"'),
        (
            {"sequence": replace(sequence_of(6), neighbours=InTime(1, 1, 1))},
            "neighbours.before = 25, now it is 1",
        ),
    ],
)  # fmt: skip
def test_another_job_in_the_same_folder_is_refused(finished, change, named):
    job, script, _ = finished
    with pytest.raises(LabelFilesError, match=named):
        run(replace(job, **change))
    assert len(script.computed()) == 6


def test_a_frame_that_fails_is_named_and_the_others_come_out(tmp_path, scripts):
    script = scripts.Scripted(tmp_path / "log", fails_at=("left/002",))
    job = job_of(tmp_path / "labels", script)
    outcomes = run(job)
    assert states(outcomes) == {"done": 5, "failed": 1}
    assert outcomes["left/002"].reason == "left/002.png: no such file"
    assert not frame_path(job.folder, "left/002").exists()
    mended = run(replace(job, labeller=scripts.Scripted(tmp_path / "second")))
    assert states(mended) == {"done": 1, "kept": 5}


def test_what_is_wrong_with_all_frames_stops_the_job_at_once(tmp_path, scripts):
    script = scripts.Scripted(tmp_path / "log", refuses="no such teacher")
    with pytest.raises(FootprintsError, match="no such teacher"):
        run(job_of(tmp_path / "labels", script))
    assert not (tmp_path / "labels").exists()


def test_a_worker_that_dies_costs_nothing(tmp_path, scripts):
    script = scripts.Scripted(tmp_path / "log", dies_once_at=("left/001", "left/004"))
    outcomes = run(job_of(tmp_path / "labels", script))
    assert states(outcomes) == {"done": 6}
    computed = Counter(name for name, _ in script.computed())
    assert computed == Counter(list(outcomes)) + Counter(["left/001", "left/004"])


def test_a_frame_that_kills_its_worker_costs_only_itself(tmp_path, scripts):
    script = scripts.Scripted(tmp_path / "log", dies_at=("left/001",))
    outcomes = run(job_of(tmp_path / "labels", script), processes=1)
    assert states(outcomes) == {"done": 5, "failed": 1}
    assert "died" in outcomes["left/001"].reason
    computed = Counter(name for name, _ in script.computed())
    assert computed == Counter(list(outcomes)) + Counter(["left/001"])


def test_an_interrupted_job_leaves_whole_files_and_goes_on(tmp_path, scripts):
    script = scripts.Scripted(tmp_path / "log", pause_s=0.1)
    job = job_of(tmp_path / "labels", script, count=40)
    process = multiprocessing.get_context("spawn").Process(
        target=make_labels, args=(job, partial(run_in_processes, processes=2), print)
    )
    process.start()
    while len(list(job.folder.rglob("*.npz"))) < 3:
        assert process.is_alive()
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGINT)
    process.join(30)
    assert process.exitcode != 0
    left = [path for path in job.folder.rglob("*") if path.is_file() and path.suffix != ".npz"]
    assert [path.name for path in left] == ["labels.json"]
    before = {path: path.stat().st_mtime_ns for path in job.folder.rglob("*.npz")}
    assert 3 <= len(before) < 40
    for path in before:
        read_frame(job.folder, f"left/{path.stem}")
    outcomes = run(replace(job, labeller=replace(script, pause_s=0.0)))
    assert states(outcomes) == {"kept": len(before), "done": 40 - len(before)}
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert max(Counter(name for name, _ in script.computed()).values()) == 1


def test_labels_are_training_data(finished):
    job, _, _ = finished
    samples = list(read_video_labels(job.folder))
    assert [sample.name for sample in samples] == [f"made/left/{i:03d}" for i in range(6)]
    sample = samples[2]
    assert (sample.visible_ground[6:, :8] == YES).all()
    assert (sample.visible_ground[6:, 8:] == NO).all()
    assert (sample.ground[6:] == YES).all()
    assert (sample.ground[:6] == UNSEEN).all()
    assert (sample.ground_depth_m[6:] == 3.5).all()
    assert (sample.visible_depth_m == 5.0).all()
    assert not sample.moving.any()

    datasets = load_datasets(job.folder.parent)
    assert list(datasets) == ["labels"]
    assert len(datasets["labels"].train) == 4
    assert [sample.name for sample in datasets["labels"].held_out] == [
        "made/left/004",
        "made/left/005",
    ]


def test_the_contact_sheet_shows_frames_from_first_to_last(finished):
    job, _, _ = finished
    sheet = np.asarray(draw_contact_sheet(job.folder, rows=3))
    assert sheet.shape[1] == WIDTH_PX
    # Visible ground is green, hidden ground beside it blue, and both have a distance.
    green = (sheet[..., 1] > sheet[..., 0] + 40) & (sheet[..., 1] > sheet[..., 2] + 40)
    blue = (sheet[..., 2] > sheet[..., 0] + 60) & (sheet[..., 2] > sheet[..., 1] + 40)
    middle = slice(WIDTH_PX // 2, 3 * WIDTH_PX // 4)
    assert green[:, middle].mean() > 0.1
    assert blue[:, middle].mean() > 0.1
    many, few = (draw_contact_sheet(job.folder, rows=rows).height for rows in (50, 2))
    assert many > few
    assert draw_contact_sheet(job.folder, rows=6).height == many


def test_labels_json_says_what_made_them(finished):
    job, _, _ = finished
    about = json.loads((job.folder / "labels.json").read_text())
    assert about["sequence"] == "made"
    assert about["settings"]["size"] == [12, 16]
    assert about["neighbours"] == {"kind": "InTime", "before": 25, "after": 50, "step": 2}
    assert set(about["made_with"]) == {"footprints-edge", "numpy", "opencv", "pillow"}


def test_opencv_may_come_from_any_of_its_distributions(tmp_path, monkeypatch):
    def absent(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr("importlib.metadata.Distribution.from_name", absent)
    claim(tmp_path, sequence_of(1), LabelSettings())
    assert json.loads((tmp_path / "labels.json").read_text())["made_with"]["opencv"]


@pytest.fixture
def clip(tmp_path, scene, box, pose):
    """Seven RGB-D frames past a crate, with ground segmentation in the sixth and seventh only."""
    folder = tmp_path / "walk"
    for name in ("images", "depth", "labels"):
        (folder / name).mkdir(parents=True)
    camera, size = Intrinsics(60.0, 60.0, 31.5, 23.5), (48, 64)
    room = scene((box((1.6, -0.4, 0.0), (2.0, 0.4, 0.5)),))
    frames = []
    for index, y in enumerate(np.linspace(-1.5, 1.5, 7)):
        at, name = pose((0, y, 1.5), (2.5, 0, 0)), f"{index:02d}"
        depth_m = room.depth_m(at, camera, size)
        depth_mm = np.where(depth_m < 8, 1000 * depth_m, 0).astype(np.uint16)
        Image.fromarray(depth_mm).save(folder / "depth" / f"{name}.png")
        Image.fromarray(np.full((*size, 3), 120, np.uint8)).save(folder / "images" / f"{name}.jpg")
        if index > 4:
            Image.fromarray(np.full(size, 4, np.uint8)).save(folder / "labels" / f"{name}.png")
        frames.append({"name": name, "camera_to_world": at.tolist()})
    matrix = [[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]]
    stated = {"intrinsics": matrix, "frames": frames, "gravity_direction": [0, 0, -1]}
    (folder / "sequence.json").write_text(json.dumps(stated))
    return folder


def command(*arguments):
    result = CliRunner().invoke(app, ["labels", *map(str, arguments)])
    return result.exit_code, result.stdout, result.stderr


def test_the_command_labels_a_clip_and_goes_on_with_it(clip, tmp_path):
    out = tmp_path / "labels"
    arguments = (clip, "-o", out, "--ground", "depth", "-j", 1, "--before", 6, "--after", 6)
    code, stdout, stderr = command(*arguments, "--step", 1)
    assert code == 0, stderr
    summary = json.loads(stdout)
    assert (summary["frames"], summary["done"], summary["failed"]) == (7, 7, 0)
    assert 0 < summary["hidden_ground_share"] < 0.5
    assert summary["frames_per_second"] > 0
    assert Image.open(summary["contact_sheet"]).width == WIDTH_PX
    again = json.loads(command(*arguments, "--step", 1)[1])
    assert (again["done"], again["kept"]) == (0, 7)
    assert again["hidden_ground_share"] == summary["hidden_ground_share"]
    code, stdout, stderr = command(*arguments, "--step", 2)
    assert (code, stdout) == (2, "")
    assert "neighbours.step = 1, now it is 2" in stderr


def test_the_command_names_frames_that_fail(clip, tmp_path):
    out = tmp_path / "labels"
    code, stdout, stderr = command(clip, "-o", out, "-j", 1)
    assert code == 1
    summary = json.loads(stdout)
    assert (summary["done"], summary["failed"]) == (2, 5)
    for name in ("00", "01", "02", "03", "04"):
        assert f"{name} failed: {name} comes without a ground segmentation" in stderr
        assert not frame_path(out, name).exists()
    assert frame_path(out, "05").exists()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--size", "256"], "256x448"),
        (["--ground", "teacher"], "teacher"),
        (["--source", "there", "--ground", "teacher"], "there"),
    ],
)
def test_wrong_options_are_usage_errors(clip, tmp_path, options, says):
    code, stdout, stderr = command(clip, "-o", tmp_path / "labels", *options)
    assert (code, stdout) == (2, "")
    assert says in stderr
    assert not (tmp_path / "labels").exists()


def test_a_folder_without_a_sequence_is_a_usage_error(tmp_path):
    code, _, stderr = command(tmp_path, "-o", tmp_path / "labels")
    assert code == 2
    assert "sequence.json" in stderr
