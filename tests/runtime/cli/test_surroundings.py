"""`fp-infer` in odd surroundings: closed streams, links, names, formats that fail, signals."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper
from PIL import Image
from typer.testing import CliRunner

from footprints_edge.cli.infer import app

COMMAND = [sys.executable, "-m", "footprints_edge"]
posix = pytest.mark.skipif(sys.platform == "win32", reason="POSIX shells and signals")


@pytest.fixture
def photos(tmp_path, picture):
    """Two pictures in the folder that is returned."""
    for name in ("a.png", "b.png"):
        Image.fromarray(picture).save(tmp_path / name)
    return tmp_path


def run(folder, tiny_path, words, redirection="", **environment):
    return subprocess.run(
        ["sh", "-c", f'exec "$@" {redirection}', "sh", *COMMAND, *words, "--model", str(tiny_path)],
        cwd=folder,
        capture_output=True,
        check=False,
        env=os.environ | environment,
        timeout=100,
    )


@posix
@pytest.mark.parametrize("redirection", ["2>&-", "2>&- <&-", ">&- 2>&- <&-"])
def test_closed_streams_lose_no_result(photos, tiny_path, redirection):
    result = run(photos, tiny_path, ["a.png", "b.png", "--format", "json", "-v"], redirection)
    assert result.returncode == 0
    for name in ("a.png.json", "b.png.json"):
        json.loads((photos / name).read_text())


@posix
def test_without_a_standard_input_that_is_said(photos, tiny_path):
    result = run(photos, tiny_path, ["-", "a.png", "--format", "json"], "<&-")
    assert (result.returncode, b"standard input is empty" in result.stderr) == (1, True)
    assert (photos / "a.png.json").exists()


@posix
@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp437", "utf-8"])
def test_any_name_is_printed_as_the_system_spells_it(photos, tiny_path, encoding):
    names = [os.fsencode("grün你.png"), b"gr\xfcn.png"]
    for name in names:
        (photos / os.fsdecode(name)).write_bytes((photos / "a.png").read_bytes())
    words = [*map(os.fsdecode, names), "--format", "json"]
    result = run(photos, tiny_path, words, PYTHONIOENCODING=encoding)
    assert result.returncode == 0, result.stderr
    if encoding in {"ascii", "utf-8"}:
        assert result.stdout.split() == [name + b".json" for name in names]


@posix
def test_a_link_to_itself_does_not_stop_the_others(photos, tiny_path):
    (photos / "loop.jpg").symlink_to("loop.jpg")
    result = run(photos, tiny_path, ["loop.jpg", "a.png", "--format", "json"])
    assert (result.returncode, result.stdout) == (1, b"a.png.json\n")
    assert b"loop.jpg" in result.stderr and b"Traceback" not in result.stderr


def test_a_format_that_fails_does_not_stop_the_others(infer, tmp_path):
    Image.new("RGB", (64, 48), (0, 0, 99)).save(tmp_path / "water.png")
    formats = "json,topdown,overlay,npz,topdown_picture"
    result = infer(tmp_path / "water.png", "--format", formats)
    assert result.exit_code == 1
    assert "1 of 1 failed" in result.stderr
    written = [str(tmp_path / f"water.png{end}") for end in (".json", ".overlay.png", ".npz")]
    assert result.stdout.split() == written


def test_what_a_folder_leaves_out_is_said(infer, photos):
    for name in ("c.jfif", "d.JPE"):
        Image.open(photos / "a.png").save(photos / name, "JPEG")
    for name in ("e.dng", "f.gif", "g.GIF", "notes.txt"):
        (photos / name).write_bytes(b"?")
    (photos / "away.jpg").symlink_to("nowhere.jpg")
    (photos / "h.mp4").write_bytes(b"?")
    result = infer(photos, "--format", "json")
    assert (result.exit_code, len(result.stdout.split())) == (0, 4)
    assert "passed over 2 .gif, 1 .dng, 1 link that leads nowhere" in result.stderr
    assert "videos beside pictures are done only by name: 1" in result.stderr
    assert "Note" not in infer(photos, "--format", "json", "-q").stderr


@posix
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("after_s", [0.02, 0.05, 0.12, 0.3])
def test_a_signal_while_it_starts_ends_with_130(photos, tiny_path, sent, after_s):
    code = "from footprints_edge.cli.start import infer; print(flush=True); infer()"
    os.mkfifo(photos / "never")
    process = subprocess.Popen(
        [sys.executable, "-c", code, "never", "--model", str(tiny_path)],
        cwd=photos,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    process.stdout.read(1)
    time.sleep(after_s)
    process.send_signal(sent)
    _, errors = process.communicate(timeout=30)
    assert (process.returncode, errors) == (130, b"")


def test_a_model_that_gives_no_maps_is_a_problem_of_the_model(photos, tmp_path, metadata):
    values = numpy_helper.from_array(np.float32(np.nan), "nan")
    graph = helper.make_graph(
        [
            helper.make_node("Cast", ["image"], ["float"], to=TensorProto.FLOAT),
            helper.make_node("Transpose", ["float"], ["planes"], perm=[0, 3, 1, 2]),
            helper.make_node("Concat", ["planes", "planes"], ["six"], axis=1),
            helper.make_node("Slice", ["six", "begin", "end", "axis"], ["four"]),
            helper.make_node("Mul", ["four", "nan"], ["maps"]),
        ],
        "nan",
        [helper.make_tensor_value_info("image", TensorProto.UINT8, [1, "H", "W", 3])],
        [helper.make_tensor_value_info("maps", TensorProto.FLOAT, [1, 4, "H", "W"])],
        [values]
        + [
            numpy_helper.from_array(np.array([n]), k)
            for k, n in zip(("begin", "end", "axis"), (0, 4, 1), strict=True)
        ],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=10)
    helper.set_model_props(model, metadata.to_props())
    onnx.save(model, tmp_path / "nan.onnx")
    result = CliRunner().invoke(app, [str(photos / "a.png"), "--model", str(tmp_path / "nan.onnx")])
    assert result.exit_code == 3
    assert "values from nan to nan" in result.stderr


@pytest.mark.parametrize(
    "option", ["--no-flatten", "--engine=onnxruntime", "--provider=CPUExecutionProvider"]
)
def test_what_python_can_choose_the_command_can(option, infer, photos):
    assert infer(photos / "a.png", "--format", "json", option).exit_code == 0


def test_an_unknown_engine_is_a_problem_of_the_model(infer, photos):
    result = infer(photos / "a.png", "--engine", "other")
    assert (result.exit_code, "'other' is unknown" in result.stderr) == (3, True)


def test_the_password_of_an_address_that_is_not_read_is_not_shown(infer, photos):
    named = ["http://me:hunter22@10.0.0.7/a.jpg", "ftp://me:hunter22@10.0.0.7/a.mp4"]
    result = infer(photos / "a.png", *named, "--format", "json")
    assert (result.exit_code, len(result.stdout.split())) == (1, 1)
    assert result.stderr.count("***@10.0.0.7/a.") == 2
    assert "hunter22" not in result.stderr


def test_a_folder_of_videos_gives_its_videos(infer, tmp_path, clip):
    (tmp_path / "videos").mkdir()
    for name in ("a.avi", "b.avi"):
        (tmp_path / "videos" / name).write_bytes(clip.read_bytes())
    result = infer(tmp_path / "videos", "--format", "json", "--every", "10")
    assert (result.exit_code, len(result.stdout.split())) == (0, 2)


@pytest.mark.parametrize("name", ["infer", "models", "export", "train", "bench"])
def test_every_command_has_help_and_a_version(name):
    for word, said in (("-h", b"Usage:"), ("--version", b"footprints-edge ")):
        code = f"import sys; sys.argv = ['fp', '{word}']; "
        code += f"from footprints_edge.cli import start; start.{name}()"
        result = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
        assert said in result.stdout


def test_a_command_run_as_a_module_is_imported_once():
    command = [sys.executable, "-X", "importtime", "-m", "footprints_edge.cli.models", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "footprints-edge" in done.stdout
    assert "footprints_edge.cli.start" in done.stderr
    assert "footprints_edge.cli.models" not in done.stderr
