import hashlib
import json
from pathlib import Path

import pytest

from footprints_edge import load
from footprints_edge.errors import ModelError
from footprints_edge.model_files import registry


@pytest.fixture
def data(tmp_path, model_bytes, monkeypatch):
    content = model_bytes()
    (tmp_path / "small.onnx").write_bytes(content)
    facts = {
        "file": "small.onnx",
        "sha256": hashlib.sha256(content).hexdigest(),
        "bytes": len(content),
        "licence": "Apache-2.0",
        "description": "for tests",
    }
    gone = facts | {"file": "gone.onnx"}
    manifest = {"default": "small", "models": {"small": facts, "gone": gone}}
    (tmp_path / "models.json").write_text(json.dumps(manifest))
    monkeypatch.setattr(registry, "DATA", tmp_path)
    return tmp_path


def test_names_defaults_and_paths(data):
    assert registry.resolve(None) == registry.resolve("small") == data / "small.onnx"
    assert registry.resolve(data / "small.onnx") == data / "small.onnx"
    assert [(entry.name, entry.default) for entry in registry.bundled_models()] == [
        ("small", True),
        ("gone", False),
    ]


@pytest.mark.usefixtures("data")
def test_unknown_names_list_the_known_ones():
    with pytest.raises(ModelError, match=r"'large' is neither.*small, gone"):
        registry.resolve("large")


def test_a_folder_is_not_a_model(data):
    with pytest.raises(ModelError, match="is a folder"):
        registry.resolve(data)


@pytest.mark.usefixtures("data")
def test_a_missing_bundled_file_is_explained():
    with pytest.raises(ModelError, match="reinstall"):
        registry.resolve("gone")


def test_without_a_manifest_only_files_work(tmp_path, monkeypatch):
    monkeypatch.setattr(registry, "DATA", tmp_path)
    assert registry.bundled_models() == []
    with pytest.raises(ModelError, match="bundles no model"):
        registry.resolve(None)


@pytest.mark.parametrize("text", ["{", "[]", '{"models": {"a": {}}}', '{"models": []}'])
def test_a_damaged_manifest_is_explained(text, tmp_path, monkeypatch):
    monkeypatch.setattr(registry, "DATA", tmp_path)
    (tmp_path / "models.json").write_text(text)
    with pytest.raises(ModelError, match="damaged"):
        registry.bundled_models()


def test_a_changed_byte_is_noticed_on_loading(data):
    assert load(threads=1).name == "tiny"
    path = data / "small.onnx"
    path.write_bytes(path.read_bytes().replace(b"none: the maps", b"none! the maps"))
    with pytest.raises(ModelError, match=r"is damaged.*expected"):
        load("small", threads=1)
    copy = data / "copy.onnx"
    copy.write_bytes(path.read_bytes())
    assert load(copy, threads=1).metadata.training.startswith("none!")


@pytest.mark.skipif(not registry.bundled_models(), reason="no model is bundled yet")
def test_the_bundled_models_are_whole():
    for entry in registry.bundled_models():
        content = entry.path.read_bytes()
        assert hashlib.sha256(content).hexdigest() == entry.sha256
        assert len(content) == entry.bytes


@pytest.mark.parametrize("page", ["porting.md", "model-file.md"])
def test_the_documentation_states_size_and_hash_of_the_bundled_file(page):
    (model,) = (each for each in registry.bundled_models() if each.name == load().name)
    facts = json.loads((registry.DATA / "models.json").read_text())["models"][model.name]
    text = (Path(__file__).parents[3] / "docs" / page).read_text()
    assert facts["sha256"] in text
    assert f"{facts['bytes']:,} bytes" in text
