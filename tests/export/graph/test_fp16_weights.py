"""Weights in half precision: half the bytes, nearly the same maps, or no file."""

import json

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper

import footprints_edge as fp
from footprints_edge.inputs.preprocessing import preprocess
from footprints_edge_export.convert import convert
from footprints_edge_export.errors import ExportError, VerificationError
from footprints_edge_export.graph.fp16_weights import store_weights_in_half
from footprints_edge_export.verification.bounds import BOUNDS

SIZE = (64, 96)


def picture(seed=0):
    pixels = np.random.default_rng(seed).integers(0, 256, (16, 24, 3), np.uint8)
    return preprocess(pixels, SIZE)


def maps(path):
    return fp.load(path, threads=1).engine.run(picture())


def test_half_precision_halves_the_file_and_hardly_moves_the_maps(half, edge_fixed):
    path, report = half
    plain = edge_fixed[0]
    assert path.stat().st_size < 0.55 * plain.stat().st_size
    assert fp.load(path).metadata.precision == "fp16"
    apart = np.abs(maps(path) - maps(plain)).max()
    assert 0 < apart < 0.02  # 11 bits of every weight: not the same, not far
    assert report.fp32_to_fp16["ground_iou"] >= 0.99
    assert report.fp32_to_fp16["photos"] == 1  # a real one: on noise the masks of a good file jump
    assert json.loads((path.parent / "edge.onnx.json").read_text())["target"] == "web"


def test_half_precision_keeps_every_large_weight_and_no_large_float(half):
    constants = {t.name: numpy_helper.to_array(t) for t in onnx.load(half[0]).graph.initializer}
    halves = [value for value in constants.values() if value.dtype == np.float16]
    assert sum(value.size for value in halves) > 3e6
    assert max(v.size for v in constants.values() if v.dtype == np.float32) < 256


def test_half_precision_that_changes_too_much_leaves_nothing(
    edge_checkpoint, conversion, tmp_path, monkeypatch
):
    monkeypatch.setitem(BOUNDS, "fp16", (1.1, 0.0))
    wanted = conversion(size=SIZE, precision="fp16")
    with pytest.raises(VerificationError, match="fp16 changes the masks"):
        convert(edge_checkpoint, tmp_path / "a.onnx", wanted, overwrite=False)
    assert list(tmp_path.iterdir()) == []


def test_weights_beyond_half_precision_are_refused(rewritten):
    weights = numpy_helper.from_array(np.full(300, 1e5, np.float32), "w")
    kind = helper.make_tensor_value_info("y", TensorProto.FLOAT, [300])
    nodes = [helper.make_node("Identity", ["w"], ["y"])]
    model = helper.make_model(helper.make_graph(nodes, "big", [], [kind], [weights]))
    with pytest.raises(ExportError, match=r"w is 100000.*fp32"):
        rewritten(store_weights_in_half, model)
