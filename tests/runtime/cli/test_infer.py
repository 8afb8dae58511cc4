import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from footprints_edge.cli.infer import app as infer_app
from footprints_edge.cli.models import app as models_app


@pytest.fixture
def photos(tmp_path, picture):
    """A folder of two pictures, and a third in a sub-folder."""
    folder = tmp_path / "photos"
    (folder / "sub").mkdir(parents=True)
    for name in ("a.png", "b.bmp", "sub/a.png"):
        Image.fromarray(picture).save(folder / name)
    return folder


def command(tool, *arguments):
    return [sys.executable, "-m", f"footprints_edge.cli.{tool}", *map(str, arguments)]


def test_the_overlay_comes_beside_the_picture(infer, photos):
    result = infer(photos / "a.png")
    assert result.exit_code == 0, result.output
    assert result.stdout.splitlines() == [str(photos / "a.png.overlay.png")]
    assert (photos / "a.png.overlay.png").is_file()
    assert result.stderr.startswith("Assumed a lens of 60 degrees")
    assert result.stderr.count("\n") == 1


def test_a_lens_that_was_assumed_is_said_once_and_one_that_is_known_never(infer, photos, tmp_path):
    several = infer(photos, "--recursive", "-o", tmp_path / "a")
    assert several.stderr.count("Assumed a lens") == 1
    known = infer(photos / "a.png", "--hfov", "70", "-o", tmp_path / "b")
    assert known.stderr == ""


def test_the_known_pose_is_in_the_json(infer, photos, tmp_path):
    options = ("--camera-height", "1.2", "--pitch", "15", "--roll", "-2")
    result = infer(photos / "a.png", "--format", "json", "-o", tmp_path, *options)
    assert result.exit_code == 0, result.output
    plane = json.loads((tmp_path / "a.png.json").read_text())["ground_plane"]
    assert plane["camera_height_m"] == pytest.approx(1.2)
    assert (plane["pitch_deg"], plane["roll_deg"]) == pytest.approx((15, -2))
    assert plane["known"] == ["camera_height_m", "pitch_deg", "roll_deg"]
    wrong = infer(photos / "a.png", "--camera-height", "0", "-o", tmp_path / "c")
    assert wrong.exit_code != 0
    assert "camera height is 0" in wrong.stderr


def test_all_formats_of_a_folder_keeping_sub_folders(infer, photos, tmp_path):
    out = tmp_path / "out"
    result = infer(
        photos, "-o", out, "--recursive", "--format", "overlay,npz", "--format", "png16, json,ply"
    )
    assert result.exit_code == 0, result.output
    written = result.stdout.splitlines()
    assert len(written) == 3 * 9
    assert sorted(written) == sorted(str(path) for path in out.rglob("*") if path.is_file())
    assert (out / "sub" / "a.png.json").is_file()


def test_a_second_run_keeps_results_and_does_not_read_them(infer, photos):
    assert infer(photos).exit_code == 0
    before = {path: path.stat().st_mtime_ns for path in photos.iterdir()}
    again = infer(photos)
    assert (again.exit_code, again.stdout) == (0, "")
    assert "Kept 2" in again.stderr
    assert {path: path.stat().st_mtime_ns for path in photos.iterdir()} == before
    more = infer(photos, "--format", "overlay,json", "-q")
    assert more.stdout.splitlines() == [str(photos / "a.png.json"), str(photos / "b.bmp.json")]
    assert more.stderr == ""
    assert len(infer(photos, "--overwrite").stdout.splitlines()) == 2


@pytest.mark.parametrize("more", [[], ["--format", "overlay,json"]], ids=["all kept", "some new"])
def test_a_run_that_completes_removes_what_a_killed_one_left(infer, photos, more):
    assert infer(photos).exit_code == 0
    die = (
        "import os; from pathlib import Path; from footprints_edge.foundation.parts import *; "
        f"new_part(Path({str(photos)!r})).touch(); os._exit(9)"
    )
    assert subprocess.call([sys.executable, "-c", die]) == 9
    assert len(list(photos.glob(".*"))) == 1
    assert infer(photos, *more).exit_code == 0
    assert not list(photos.glob(".*"))


def test_one_bad_file_among_good_ones(infer, photos):
    (photos / "broken.jpg").write_bytes(b"\xff\xd8\xff no")
    result = infer(photos, photos / "missing.jpg")
    assert result.exit_code == 1
    assert len(result.stdout.splitlines()) == 2
    assert "2 of 4 failed" in result.stderr
    assert "broken.jpg is not an image" in result.stderr
    assert "missing.jpg: no such file" in result.stderr


@pytest.mark.parametrize("size", [(1, 3000), (3000, 1), (2, 2), (1, 1)])
def test_pictures_of_odd_shape_get_every_format(infer, tmp_path, size):
    Image.new("RGB", size, "green").save(tmp_path / "odd.png")
    result = infer(tmp_path / "odd.png", "--format", "overlay,npz,png16,json,ply")
    assert result.exit_code == 0, result.output
    assert len(result.stdout.splitlines()) == 9


def test_a_picture_that_breaks_the_network_leaves_the_others(infer, photos, monkeypatch):
    from footprints_edge.engines.onnxruntime_engine import OnnxRuntimeEngine
    from footprints_edge.errors import ModelError

    run, broken = (
        OnnxRuntimeEngine.run,
        iter([ModelError("failed on this input"), RuntimeError("a bug")]),
    )

    def breaks_twice(session, image):
        if (error := next(broken, None)) is not None:
            raise error
        return run(session, image)

    monkeypatch.setattr(OnnxRuntimeEngine, "run", breaks_twice)
    result = infer(photos, "--recursive")
    assert result.exit_code == 1
    assert len(result.stdout.splitlines()) == 1
    assert "2 of 3 failed" in result.stderr
    assert "RuntimeError: a bug" in result.stderr


def test_a_picture_named_twice_is_done_once(infer, photos):
    result = infer(photos, photos / "a.png", photos / "sub" / ".." / "b.bmp")
    assert result.exit_code == 0, result.output
    assert len(result.stdout.splitlines()) == 2


def test_planning_a_large_folder_resolves_each_path_a_few_times_only(tmp_path, monkeypatch):
    from footprints_edge.cli.batch import plan

    for index in range(200):
        (tmp_path / f"{index}.png").write_bytes(b"")
    resolve, calls = Path.resolve, []
    monkeypatch.setattr(Path, "resolve", lambda path: calls.append(path) or resolve(path))
    batch = plan([str(tmp_path)], ["overlay"], None, recursive=False, overwrite=False)
    assert len(batch.tasks) == 200
    assert len(calls) <= 5 * 200


def test_an_impossible_name_fails_alone(infer, photos):
    result = infer(photos / ("x" * 300 + ".png"), photos / "a.png")
    assert result.exit_code == 1
    assert result.stdout.splitlines() == [str(photos / "a.png.overlay.png")]


def test_a_long_name_still_gets_its_results(infer, photos):
    name = "y" * 220 + ".png"
    (photos / "a.png").rename(photos / name)
    assert infer(photos / name, "--format", "json").exit_code == 0


def test_a_second_picture_from_stdin_is_not_taken_for_the_first(infer, photos, tmp_path):
    data = (photos / "a.png").read_bytes()
    assert infer("-", "-o", tmp_path / "out", input=data).exit_code == 0
    again = infer("-", "-o", tmp_path / "out", input=data)
    assert again.exit_code == 1
    assert "--overwrite" in again.stderr


def test_an_empty_folder_fails_alone(infer, photos, tmp_path):
    (tmp_path / "empty").mkdir()
    result = infer(tmp_path / "empty", photos / "a.png")
    assert result.exit_code == 1
    assert len(result.stdout.splitlines()) == 1
    assert "no picture in this folder" in result.stderr


def test_equal_names_from_two_folders_do_not_overwrite_each_other(infer, photos, tmp_path):
    result = infer(photos / "a.png", photos / "sub" / "a.png", "-o", tmp_path / "out")
    assert result.exit_code == 1
    assert len(result.stdout.splitlines()) == 1
    assert "different -o folders" in result.stderr


def test_an_input_is_never_overwritten(infer, photos):
    (photos / "b.bmp").rename(photos / "a.png.overlay.png")
    before = (photos / "a.png.overlay.png").read_bytes()
    result = infer(photos / "a.png", photos / "a.png.overlay.png", "--overwrite")
    assert result.exit_code == 1
    assert "input picture" in result.stderr
    assert (photos / "a.png.overlay.png").read_bytes() == before


@pytest.mark.parametrize(
    ("options", "focal_px"),
    [
        (["--fx", "80", "--fy", "80"], 80),
        (["--hfov", "90"], 50),
        ([], 50 / np.tan(np.radians(30))),
    ],
)
def test_the_camera_reaches_the_json(infer, photos, options, focal_px):
    assert infer(photos / "a.png", "--format", "json", *options).exit_code == 0
    camera = json.loads((photos / "a.png.json").read_text())["camera"]
    assert camera["focal_length_px"] == pytest.approx(focal_px)
    assert camera["cx_px"] == pytest.approx(49.5)
    assert camera["source"] == ("given" if options else "assumed")


def test_the_threshold_reaches_the_json(infer, photos):
    infer(photos / "a.png", "--format", "json", "--threshold", "0.9")
    assert json.loads((photos / "a.png.json").read_text())["threshold"] == 0.9


@pytest.mark.parametrize(
    "options",
    [
        [],
        ["a.png", "--fx", "80"],
        ["a.png", "--cx", "80"],
        ["a.png", "--fx", "80", "--fy", "80", "--hfov", "60"],
        ["a.png", "--hfov", "200"],
        ["a.png", "--fx", "-1", "--fy", "2"],
        ["a.png", "--format", "gif"],
        ["a.png", "--threshold", "2"],
        ["a.png", "--threads", "0"],
        ["a.png", "--margin", "0.3"],
        ["a.png", "--bev", "--format", "json"],
        ["a.png", "--nonsense"],
    ],
)
def test_wrong_usage_is_exit_code_2(options):
    result = CliRunner().invoke(infer_app, options)
    assert result.exit_code == 2
    assert result.stderr
    assert "Traceback" not in result.output


def test_model_problems_are_exit_code_3(photos):
    result = CliRunner().invoke(infer_app, [str(photos), "--model", "nonsense"])
    assert (result.exit_code, result.stdout) == (3, "")
    assert "neither a file nor a registered name" in result.stderr


def test_verbose_prints_a_line_per_picture(infer, photos):
    result = infer(photos, "-v")
    assert result.stderr.count("100 x 60 px") == 2
    assert "(assumed)" in result.stderr


def test_a_real_process_reads_stdin_and_writes_here(tiny_path, picture, tmp_path):
    buffer = io.BytesIO()
    Image.fromarray(picture).save(buffer, "PNG")
    result = subprocess.run(
        command("infer", "-", "--model", tiny_path, "--format", "json"),
        input=buffer.getvalue(),
        capture_output=True,
        cwd=tmp_path,
        check=False,
    )
    assert (result.returncode, result.stdout.decode()) == (0, f"stdin.json{os.linesep}")
    assert json.loads((tmp_path / "stdin.json").read_text())["image_size_px"] == [60, 100]


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has file names that are no text")
def test_a_real_process_takes_any_file_name(tiny_path, photos):
    name = b"gr\xc3\xbc\xc3\x9fe \xe5\x86\x99 \xff.png"
    (photos / "a.png").rename(photos / os.fsdecode(name))
    result = subprocess.run(
        command("infer", photos, "--model", tiny_path, "--format", "json,overlay"),
        capture_output=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert name + b".json" in result.stdout
    assert (photos / os.fsdecode(name + b".json")).is_file()


def test_a_real_process_with_a_bad_file_ends_with_1_and_no_traceback(tiny_path, photos):
    (photos / "broken.png").write_bytes(b"")
    result = subprocess.run(
        command("infer", photos, "--model", tiny_path), capture_output=True, text=True, check=False
    )
    assert result.returncode == 1
    assert len(result.stdout.splitlines()) == 2
    assert "1 of 3 failed" in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals")
def test_ctrl_c_ends_quietly_with_130(tiny_path, photos):
    os.mkfifo(photos / "never")  # reading it waits for ever
    process = subprocess.Popen(
        command("infer", photos / "a.png", photos / "never", "--model", tiny_path, "-q"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout.readline()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=20)
    assert (process.returncode, errors) == (130, b"")


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX pipes")
def test_pictures_are_worked_on_at_once_and_named_in_order(tiny_path, tmp_path, picture):
    """The first one is a pipe that gets its picture when the second one's result is there."""
    out, first = tmp_path / "out", tmp_path / "a.png"
    os.mkfifo(first)
    Image.fromarray(picture).save(tmp_path / "b.png")
    process = subprocess.Popen(
        [
            *command("infer", first, tmp_path / "b.png", "--model", tiny_path, "-o", out, "-q"),
            *("--threads", "2", "--format", "json"),
        ],
        stdout=subprocess.PIPE,
        text=True,
    )
    end = time.monotonic() + 60
    while not (out / "b.png.json").exists() and time.monotonic() < end:
        time.sleep(0.05)
    assert (out / "b.png.json").exists()
    first.write_bytes((tmp_path / "b.png").read_bytes())
    written, _ = process.communicate(timeout=60)
    assert process.returncode == 0
    assert written.splitlines() == [str(out / "a.png.json"), str(out / "b.png.json")]


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX pipes")
def test_a_closed_pipe_leaves_no_traceback(tiny_path, photos):
    reading, writing = os.pipe()
    os.close(reading)
    process = subprocess.run(
        command("infer", photos, "--model", tiny_path, "-q"),
        stdout=writing,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    os.close(writing)
    assert (process.returncode, process.stderr) == (141, "")


def test_models_info_and_verify(tiny_path):
    result = CliRunner().invoke(models_app, ["info", str(tiny_path)])
    assert result.exit_code == 0
    assert "input: follows the picture" in result.stdout
    assert "licence: Apache-2.0" in result.stdout
    result = CliRunner().invoke(models_app, ["verify", str(tiny_path)])
    assert (result.exit_code, "whole" in result.stdout) == (0, True)


def test_models_verify_finds_the_damaged_one(tiny_path, tmp_path):
    damaged = tmp_path / "damaged.onnx"
    damaged.write_bytes(tiny_path.read_bytes()[:-50])
    result = CliRunner().invoke(models_app, ["verify", str(damaged), str(tiny_path)])
    assert result.exit_code == 3
    assert "damaged.onnx" in result.stderr
    assert "whole" in result.stdout


def test_models_list_ends_well():
    assert CliRunner().invoke(models_app, ["list"]).exit_code == 0


def test_doctor_times_the_model(tiny_path):
    result = CliRunner().invoke(models_app, ["doctor", str(tiny_path)])
    assert result.exit_code == 0, result.output
    for word in ("onnxruntime", "usable cores", "CPUExecutionProvider", "median", "advice"):
        assert word in result.stdout
