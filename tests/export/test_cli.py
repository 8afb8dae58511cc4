"""`fp-export`: results on stdout, one line on stderr where it fails, and the exit codes."""

import json
import shutil
import subprocess
import sys

import numpy as np
import onnx
import pytest
from PIL import Image
from typer.testing import CliRunner

import footprints_edge
from footprints_edge_export import cli
from footprints_edge_export.verification import parity


def fp_export(*arguments):
    """`fp-export` as a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "footprints_edge_export.cli", *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
    )


def one_line(text):
    """Whether a message is one line, and so no traceback."""
    return text.endswith("\n") and text.count("\n") == 1


@pytest.fixture
def main(monkeypatch, capsys):
    """`fp-export` in this process: exit code, stdout, stderr."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["fp-export", *map(str, arguments)])
        with pytest.raises(SystemExit) as caught:
            cli.main()
        captured = capsys.readouterr()
        return caught.value.code or 0, captured.out, captured.err

    return run


@pytest.fixture
def models(tiny_model, tmp_path):
    """Two models whose maps are apart by known amounts, and one fixed to a size."""
    paths = {name: tmp_path / f"{name}.onnx" for name in ("a", "b", "small", "large")}
    onnx.save(tiny_model(), paths["a"])
    onnx.save(tiny_model(bias=(0.1, 0.25, 0.3, 0.4)), paths["b"])
    onnx.save(tiny_model((32, 32)), paths["small"])
    onnx.save(tiny_model((32, 64)), paths["large"])
    return paths


@pytest.fixture
def pictures(tmp_path):
    folder = tmp_path / "pictures"
    folder.mkdir()
    for index in range(3):
        pixels = np.random.default_rng(index).integers(0, 256, (40, 60, 3), dtype=np.uint8)
        Image.fromarray(pixels).save(folder / f"{index}.png")
    return folder


def test_verify_prints_the_difference_as_json(main, models, pictures):
    code, out, err = main("verify", models["a"], models["b"], "--images", pictures)
    assert (code, err) == (0, "")
    found = json.loads(out)
    assert found["photos"] == 3
    assert found["max_abs"]["ground"] == pytest.approx(0.05, abs=1e-6)
    assert found["max_abs"]["visible_ground"] == found["max_abs"]["ground_depth"] == 0
    assert found["visible_depth_abs_rel"] == 0
    assert found["visible_ground_iou"] == 1


def test_verify_takes_a_fixed_size_from_either(models, pictures):
    for pair in (("a", "small"), ("small", "a")):
        arguments = ["verify", *(str(models[name]) for name in pair), "--images", str(pictures)]
        result = CliRunner().invoke(cli.app, arguments)
        assert result.exit_code == 0, result.output
        assert max(json.loads(result.stdout)["max_abs"].values()) < 1e-6


def test_models_of_two_sizes_cannot_be_compared(main, models, pictures):
    code, out, err = main("verify", models["small"], models["large"], "--images", pictures)
    assert (code, out) == (2, "")
    assert one_line(err)
    assert "different sizes: [(32, 32), (32, 64)]" in err


def test_photos_that_are_not_there_are_a_usage_error(main, models, tmp_path):
    code, out, err = main("verify", models["a"], models["b"], "--images", tmp_path / "gone")
    assert (code, out) == (2, "")
    assert one_line(err)
    assert f"{tmp_path / 'gone'}: no such folder of photos" in err


def test_photos_of_which_none_can_be_read_show_no_agreement(main, models, tmp_path):
    """A perfect score on no picture at all would be a lie."""
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "a.png").write_text("not a picture")
    code, out, err = main("verify", models["a"], models["b"], "--images", tmp_path / "broken")
    assert (code != 0, out) == (True, "")
    assert "broken" in err


def test_a_model_that_is_none_is_a_model_problem(main, models, pictures, tmp_path):
    (tmp_path / "text.onnx").write_text("not a model")
    code, out, err = main("verify", models["a"], tmp_path / "text.onnx", "--images", pictures)
    assert (code, out) == (3, "")
    assert one_line(err)
    assert "text.onnx" in err


def test_a_wrong_option_is_a_usage_error(models):
    done = fp_export("verify", models["a"])
    assert (done.returncode, done.stdout) == (2, "")
    assert "Traceback" not in done.stderr
    assert "Missing argument" in done.stderr


def test_help_needs_no_torch():
    """The help answers at once, and where only the runtime is installed."""
    code = (
        "import sys; sys.argv = ['fp-export', '--help']\n"
        "import footprints_edge_export.cli as c\n"
        "try: c.main()\n"
        "except SystemExit: pass\n"
        "print(sorted({'torch', 'onnx', 'onnxruntime'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "convert" in done.stdout
    assert done.stdout.splitlines()[-1] == "[]"


def test_convert_prints_the_file_it_wrote(main, edge_checkpoint, tmp_path):
    out_path = tmp_path / "small.onnx"
    code, out, err = main(
        *("convert", edge_checkpoint, "-o", out_path, "--arch", "edge", "--size", "64x96"),
        *("--licence", "Apache-2.0", "--training", "nothing"),
    )
    assert (code, out) == (0, f"{out_path}\n")
    assert "non-commercial" not in err
    metadata = footprints_edge.load(out_path, threads=1).metadata
    assert (metadata.name, metadata.licence) == ("small", "Apache-2.0")


def test_convert_to_int8_says_what_it_cost(main, edge_checkpoint, photos, tmp_path):
    """And counts the photos that it could read only."""
    shutil.copytree(photos, tmp_path / "photos")
    (tmp_path / "photos" / "0.png").write_text("not a picture")
    code, out, err = main(
        *("convert", edge_checkpoint, "-o", tmp_path / "a.onnx", "--arch", "edge"),
        *("--size", "64x96", "--precision", "int8", "--calibration", tmp_path / "photos"),
        *("--target", "x86-avx2"),
    )
    assert (code, out) == (0, f"{tmp_path / 'a.onnx'}\n")
    assert "visible_ground_iou" in err
    report = json.loads((tmp_path / "a.onnx.json").read_text())
    assert report["target"] == "x86-avx2"
    assert report["calibration_photos"] + report["fp32_to_int8"]["photos"] == 9


@pytest.mark.parametrize("size", ["256", "256x", "axb", "64x96x3", "100x128", "0x64"])
def test_a_size_that_is_none_is_a_usage_error(main, edge_checkpoint, tmp_path, size):
    code, out, err = main(
        *("convert", edge_checkpoint, "-o", tmp_path / "a.onnx", "--arch", "edge", "--size", size)
    )
    assert (code, out) == (2, "")
    assert "--size" in err or "multiples of 32" in err
    assert size in err or str(tuple(map(int, size.split("x")))) in err


def test_a_checkpoint_of_another_network_is_a_model_problem(main, edge_checkpoint, tmp_path):
    code, out, err = main(
        *("convert", edge_checkpoint, "-o", tmp_path / "a.onnx", "--arch", "reference")
    )
    assert (code, out) == (3, "")
    # The reference network's licence is said whatever comes of it, and then the one-line error.
    notice, *_, last = err.strip().splitlines()
    assert "non-commercial" in notice
    assert "not a checkpoint of ReferenceNetwork" in last
    assert list(tmp_path.iterdir()) == []


def test_a_checkpoint_that_is_not_there_is_no_traceback(main, tmp_path):
    code, out, err = main(
        *("convert", tmp_path / "gone.pth", "-o", tmp_path / "a.onnx", "--arch", "edge")
    )
    assert (code, out) == (3, "")
    assert one_line(err)
    assert f"{tmp_path / 'gone.pth'}: no such checkpoint" in err


def test_a_checkpoint_that_is_not_there_while_the_output_is(main, tmp_path):
    (tmp_path / "a.onnx").write_text("old")
    code, _, err = main(
        *("convert", tmp_path / "gone.pth", "-o", tmp_path / "a.onnx", "--arch", "edge"),
        "--overwrite",
    )
    assert code == 3
    assert "gone.pth" in err


def test_a_failed_verification_is_a_model_problem(main, edge_checkpoint, tmp_path, monkeypatch):
    monkeypatch.setattr(parity, "TOLERANCE", 0)
    code, out, err = main(
        *("convert", edge_checkpoint, "-o", tmp_path / "a.onnx", "--arch", "edge"),
        *("--size", "64x96"),
    )
    assert (code, out) == (3, "")
    assert "no file was written" in err
    assert list(tmp_path.iterdir()) == []
