"""A model put into the package is the one that `load()` finds."""

import json

import onnx
import pytest

import footprints_edge
from footprints_edge.errors import ModelError
from footprints_edge.model_files import registry
from footprints_edge_export.bundle import bundle
from footprints_edge_export.errors import VerificationError
from footprints_edge_export.report import report_path


@pytest.fixture
def data(tmp_path, monkeypatch):
    """An empty folder in place of the package's own."""
    monkeypatch.setattr(registry, "DATA", tmp_path / "data")
    return tmp_path / "data"


def write(model, folder, name=None):
    folder.mkdir(exist_ok=True)
    path = folder / "made.onnx"
    if name:
        (prop,) = [p for p in model.metadata_props if p.key == "footprints.name"]
        prop.value = name
    onnx.save(model, path)
    report_path(path).write_text(json.dumps({"of": name}))
    return path


def test_the_bundled_model_is_the_default_and_has_a_name(tiny_model, tmp_path, data):
    bundle(write(tiny_model(), tmp_path / "first", "one"), "the first", data)
    bundle(write(tiny_model(bias=(0, 0, 0, 0)), tmp_path / "second", "two"), "the second", data)
    assert footprints_edge.load(threads=1).name == "two"
    assert footprints_edge.load("one", threads=1).name == "one"
    listed = {model.name: model for model in registry.bundled_models()}
    assert set(listed) == {"one", "two"}
    assert [name for name, model in listed.items() if model.default] == ["two"]
    assert listed["one"].description == "the first"
    assert listed["one"].licence == "Apache-2.0"
    assert listed["one"].bytes == listed["one"].path.stat().st_size
    assert json.loads(report_path(listed["one"].path).read_text()) == {"of": "one"}


def test_a_file_changed_after_bundling_is_not_loaded(tiny_model, tmp_path, data):
    bundle(write(tiny_model(), tmp_path / "first", "one"), "the first", data)
    onnx.save(tiny_model(bias=(9, 9, 9, 9)), data / "one.onnx")
    with pytest.raises(ModelError, match=r"one\.onnx"):
        footprints_edge.load(threads=1)


def test_a_file_that_breaks_the_contract_is_not_bundled(tiny_model, tmp_path, data):
    model = tiny_model()
    model.opset_import.append(onnx.helper.make_opsetid("com.microsoft", 1))
    with pytest.raises(VerificationError):
        bundle(write(model, tmp_path / "first"), "foreign", data)
    assert not data.exists()
