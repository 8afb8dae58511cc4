"""`fp-bench latency`, `table` and `roofline`: help, messages, files."""

import json

import pytest


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["latency", "--only", "nonsense"], "matches no row"),
        (["latency", "--size", "100x100"], "multiples of 32"),
        (["latency", "--size", "wide"], "HEIGHTxWIDTH"),
        (["table", "--preset", "moon"], "kitti"),
        (["roofline", "--only", "nonsense"], "matches no row"),
        (["latency", "--trials", "1"], "trials"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(fp_bench, arguments, words):
    done = fp_bench(*arguments)
    assert done.exit_code == 2
    assert words in done.stderr
    assert not done.stdout


def test_the_command_writes_its_files_and_fails_for_a_row_of_ours(fp_bench, tmp_path):
    options = ["--trials", 2, "--threads", 1, "--network-only", "--cache", tmp_path / "cache"]
    done = fp_bench("latency", "--only", "edge 256x448 onnxruntime", *options)
    assert done.exit_code == 1  # no checkpoint here to make the float row from
    assert "Not run: edge 256x448 onnxruntime fp32" in done.stderr
    assert (tmp_path / "latency/latency.md").read_text() == done.stdout
    assert json.loads((tmp_path / "latency/latency.json").read_text())["trials"] == 2
    assert (tmp_path / "latency/latency.png").stat().st_size > 1000


def test_a_model_file_is_a_row(fp_bench, green_is_ground, tmp_path):
    options = ["--trials", 2, "--threads", 1, "--network-only", "--cache", tmp_path / "cache"]
    done = fp_bench("latency", "--only", "green", "--model", green_is_ground, *options)
    assert done.exit_code == 0, done.stderr
    assert f"{green_is_ground} 32x64 onnxruntime fp32" in done.stdout
