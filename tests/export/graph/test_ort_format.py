"""Files in onnxruntime's own format: the maps of the .onnx file, or no file."""

import subprocess

import numpy as np
import pytest

import footprints_edge as fp
from footprints_edge.inputs.preprocessing import preprocess
from footprints_edge_export.convert import convert
from footprints_edge_export.errors import ExportError, VerificationError
from footprints_edge_export.graph.ort_format import to_ort_format
from footprints_edge_export.verification.bounds import BOUNDS

SIZE = (64, 96)


def picture(seed=0):
    pixels = np.random.default_rng(seed).integers(0, 256, (16, 24, 3), np.uint8)
    return preprocess(pixels, SIZE)


def maps(path):
    return fp.load(path, threads=1).engine.run(picture())


def test_a_file_for_phones_is_of_fixed_size_and_has_its_ort_twin(mobile):
    path, report = mobile
    assert fp.load(path).engine.input_size == SIZE
    assert report.target == "mobile"
    assert report.ort["file"] == "edge.ort"
    twin = fp.load(path.with_suffix(".ort"), threads=1)
    assert twin.sha256 == report.ort["sha256"]
    assert (twin.name, twin.engine.input_size) == ("test", SIZE)
    np.testing.assert_allclose(twin.engine.run(picture()), maps(path), atol=1e-4)
    assert sorted(file.name for file in path.parent.iterdir()) == [
        "edge.onnx",
        "edge.onnx.json",
        "edge.operators.config",
        "edge.ort",
    ]


def test_the_list_of_operators_names_those_of_the_file_and_no_path(mobile):
    path, _ = mobile
    lines = path.with_suffix(".operators.config").read_text().splitlines()
    assert lines[0] == "# Operators of edge.ort"
    listed = {op for line in lines[1:] for op in line.split(";")[2].split(",")}
    assert {"Resize", "Concat"} <= listed
    assert {"Conv", "FusedConv"} & listed
    assert str(path.parent) not in "\n".join(lines)


def test_an_ort_twin_that_differs_leaves_nothing(
    edge_checkpoint, conversion, tmp_path, monkeypatch
):
    monkeypatch.setitem(BOUNDS, "ort of fp32", (1.1, 0.0))
    with pytest.raises(VerificationError, match="ort of fp32 changes"):
        wanted = conversion(size=SIZE, target="mobile")
        convert(edge_checkpoint, tmp_path / "a.onnx", wanted, overwrite=False)
    assert list(tmp_path.iterdir()) == []


def test_an_ort_twin_is_not_written_over(edge_checkpoint, conversion, tmp_path):
    (tmp_path / "a.ort").write_text("mine")
    with pytest.raises(ExportError, match=r"a\.ort exists"):
        wanted = conversion(size=SIZE, target="mobile")
        convert(edge_checkpoint, tmp_path / "a.onnx", wanted, overwrite=False)
    assert (tmp_path / "a.ort").read_text() == "mine"


def test_a_converter_that_fails_is_a_verification_error(tmp_path, monkeypatch):
    failed = subprocess.CompletedProcess([], 1, "", "lines\nof trouble\n")
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: failed)
    with pytest.raises(VerificationError, match=r"a\.ort cannot be made.*of trouble"):
        to_ort_format(tmp_path / "a.onnx", "a.ort")
