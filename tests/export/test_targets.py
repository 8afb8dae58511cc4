"""Files for the web, for phones and for each kind of CPU: what is in them, and that they agree."""

import json
import subprocess

import numpy as np
import onnx
import onnxruntime as ort
import pytest
from onnx import TensorProto, helper, numpy_helper

import footprints_edge as fp
from footprints_edge.inputs.preprocessing import preprocess
from footprints_edge_export.convert import convert
from footprints_edge_export.errors import ExportError, VerificationError
from footprints_edge_export.graph.fp16_weights import store_weights_in_half
from footprints_edge_export.graph.ort_format import to_ort_format
from footprints_edge_export.passes.pad_as_slices import pad_as_slices
from footprints_edge_export.targets import TARGETS
from footprints_edge_export.verification.bounds import BOUNDS

SIZE = (64, 96)


@pytest.fixture(scope="module")
def mobile(edge_checkpoint, conversion, tmp_path_factory):
    """The edge network for phones, float32, and its report."""
    path = tmp_path_factory.mktemp("mobile") / "edge.onnx"
    wanted = conversion(size=SIZE, target="mobile")
    return path, convert(edge_checkpoint, path, wanted, overwrite=False)


@pytest.fixture(scope="module")
def half(edge_checkpoint, conversion, tmp_path_factory):
    """The edge network for the web with weights in half precision, and its report."""
    path = tmp_path_factory.mktemp("half") / "edge.onnx"
    wanted = conversion(size=SIZE, target="web", precision="fp16")
    return path, convert(edge_checkpoint, path, wanted, overwrite=False)


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


def test_phones_get_a_size_where_none_is_named():
    assert TARGETS["mobile"].size == (256, 448)


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


def test_files_are_of_the_oldest_format_that_has_their_operators(edge_fixed, mobile, half):
    for path, _ in (edge_fixed, mobile, half):
        model = onnx.load(path)
        assert model.ir_version == 8
        assert [opset.version for opset in model.opset_import] == [18]


@pytest.mark.parametrize("mode", ["reflect", "edge"])
@pytest.mark.parametrize("pads", [(0, 0, 1, 1, 0, 0, 1, 1), (0, 0, 0, 3, 0, 0, 2, 0)])
@pytest.mark.parametrize("dtype", [np.float32, np.uint8])
def test_padding_by_slices_is_what_numpy_pads(rewritten, mode, pads, dtype):
    kind = {np.float32: TensorProto.FLOAT, np.uint8: TensorProto.UINT8}[dtype]
    graph = helper.make_graph(
        [helper.make_node("Pad", ["x", "pads"], ["y"], mode=mode)],
        "pad",
        [helper.make_tensor_value_info("x", kind, [1, 2, "H", "W"])],
        [helper.make_tensor_value_info("y", kind, [1, 2, None, None])],
        [numpy_helper.from_array(np.array(pads, np.int64), "pads")],
    )
    opsets = [helper.make_opsetid("", 18)]
    model = helper.make_model(graph, opset_imports=opsets, ir_version=8)
    model = rewritten(pad_as_slices, model)
    assert "Pad" not in {node.op_type for node in model.graph.node}
    onnx.checker.check_model(model)
    x = np.random.default_rng(0).integers(0, 99, (1, 2, 4, 5)).astype(dtype)
    session = ort.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])
    widths = list(zip(pads[:4], pads[4:], strict=True))
    np.testing.assert_array_equal(session.run(None, {"x": x})[0], np.pad(x, widths, mode=mode))


def test_zero_padding_stays_a_pad(rewritten):
    graph = helper.make_graph(
        [helper.make_node("Pad", ["x", "pads"], ["y"])],
        "pad",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, [1, 2])],
        [helper.make_tensor_value_info("y", TensorProto.FLOAT, [None, None])],
        [numpy_helper.from_array(np.array([0, 1, 0, 1], np.int64), "pads")],
    )
    model = rewritten(pad_as_slices, helper.make_model(graph))
    assert [node.op_type for node in model.graph.node] == ["Pad"]


def test_the_reference_network_for_the_web_has_no_reflecting_pad(
    reference_checkpoint, conversion, tmp_path
):
    plain, web = tmp_path / "plain.onnx", tmp_path / "web.onnx"
    for path, target in ((plain, "x86-vnni"), (web, "web")):
        wanted = conversion(architecture="reference", size=SIZE, target=target)
        convert(reference_checkpoint, path, wanted, overwrite=False)
    kinds = [[node.op_type for node in onnx.load(path).graph.node] for path in (plain, web)]
    assert ("Pad" in kinds[0], "Pad" in kinds[1]) == (True, False)
    np.testing.assert_allclose(maps(web), maps(plain), atol=1e-5)
