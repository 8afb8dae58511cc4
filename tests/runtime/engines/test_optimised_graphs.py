"""The cache of optimised graphs: the same maps, and nothing depends on it."""

import numpy as np
import onnxruntime as ort
import pytest

import footprints_edge as fp
from footprints_edge.engines import onnxruntime_engine, optimised_graphs
from footprints_edge.engines.optimised_graphs import (
    cache_folder,
    keep_optimised,
    read_optimised,
    worth_keeping,
)

SHA, OTHER = "a" * 64, "b" * 64


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    (tmp_path / "cache").mkdir()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "cache"))
    return tmp_path / "cache" / "footprints-edge"


@pytest.fixture
def levels(monkeypatch):
    """The optimisation level of each session that was made."""
    found = []

    class Watched(ort.InferenceSession):
        def __init__(self, data, options, **more):
            found.append(options.graph_optimization_level)
            super().__init__(data, options, **more)

    monkeypatch.setattr(onnxruntime_engine.ort, "InferenceSession", Watched)
    return found


ALL = ort.GraphOptimizationLevel.ORT_ENABLE_ALL
NONE = ort.GraphOptimizationLevel.ORT_DISABLE_ALL


def test_the_second_load_optimises_nothing_and_gives_the_same_maps(folder, levels):
    image = np.random.default_rng(0).integers(0, 256, (1, 128, 224, 3), np.uint8)
    first = fp.load(threads=1)
    assert len(list(folder.iterdir())) == 1
    second = fp.load(threads=1)
    assert levels == [ALL, NONE]
    np.testing.assert_array_equal(first.engine.run(image), second.engine.run(image))
    assert second.engine.props == first.engine.props
    assert (second.sha256, second.engine.input_size) == (first.sha256, first.engine.input_size)
    fp.load(threads=1, session_options={"session.intra_op.allow_spinning": "0"})
    assert levels == [ALL, NONE, ALL]


@pytest.mark.parametrize("damage", [lambda data: data[:-1], lambda _: b"", lambda data: data[::-1]])
def test_a_damaged_graph_is_thrown_away(folder, levels, damage):
    fp.load(threads=1)
    (kept,) = folder.iterdir()
    kept.write_bytes(damage(kept.read_bytes()))
    fp.load(threads=1)
    fp.load(threads=1)
    assert levels == [ALL, ALL, NONE]  # made anew, and whole again


def test_a_graph_that_the_engine_refuses_is_thrown_away(levels):
    sha256 = fp.load(threads=1).sha256
    keep_optimised(sha256, onnxruntime_engine.runtime(), b"whole, but no graph")
    fp.load(threads=1)
    assert levels == [ALL, NONE, ALL]
    fp.load(threads=1)
    assert levels[-1] == NONE


def test_an_unwritable_cache_is_no_error(folder):
    folder.write_bytes(b"a file, where the folder would be")
    assert fp.load(threads=1).predict(np.zeros((64, 64, 3), np.uint8)).ground.shape
    assert folder.read_bytes() == b"a file, where the folder would be"


def test_a_graph_is_for_one_runtime_and_one_processor(monkeypatch):
    keep_optimised(SHA, "onnxruntime 1", b"graph")
    keep_optimised(OTHER, "onnxruntime 1", b"other")
    assert read_optimised(SHA, "onnxruntime 1") == b"graph"
    assert read_optimised(SHA, "onnxruntime 2") is None
    with monkeypatch.context() as patch:
        patch.setattr(optimised_graphs, "_processor", lambda: "another one")
        assert read_optimised(SHA, "onnxruntime 1") is None
    keep_optimised(SHA, "onnxruntime 2", b"newer")
    assert read_optimised(SHA, "onnxruntime 1") is None
    assert read_optimised(OTHER, "onnxruntime 1") == b"other"


def test_few_graphs_are_kept():
    for index in range(20):
        keep_optimised(f"{index:064}", "onnxruntime 1", b"graph")
    assert len(list(cache_folder().iterdir())) <= 8
    assert read_optimised(f"{19:064}", "onnxruntime 1") == b"graph"


def test_tiny_files_and_optimised_ones_are_not_kept():
    assert not worth_keeping(b"tiny")
    assert not worth_keeping(bytes(4) + b"ORTM" + bytes(2**20))
    assert worth_keeping(bytes(2**20))


def test_a_home_without_a_cache_stays_empty(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "none"))
    keep_optimised("0" * 64, "runtime 1", b"graph")
    assert not (tmp_path / "none").exists()
