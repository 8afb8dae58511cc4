"""Padding by Slice and Concat is padding."""

import numpy as np
import onnx
import onnxruntime as ort
import pytest
from onnx import TensorProto, helper, numpy_helper

import footprints_edge as fp
from footprints_edge.inputs.preprocessing import preprocess
from footprints_edge_export.convert import convert
from footprints_edge_export.passes.pad_as_slices import pad_as_slices

SIZE = (64, 96)


def maps(path):
    pixels = np.random.default_rng(0).integers(0, 256, (16, 24, 3), np.uint8)
    return fp.load(path, threads=1).engine.run(preprocess(pixels, SIZE))


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
    reference_files, conversion, tmp_path
):
    plain, web = reference_files["fp32"], tmp_path / "web.onnx"
    wanted = conversion(architecture="reference", size=SIZE, target="web")
    convert(reference_files["checkpoint"], web, wanted, overwrite=False)
    kinds = [[node.op_type for node in onnx.load(path).graph.node] for path in (plain, web)]
    assert ("Pad" in kinds[0], "Pad" in kinds[1]) == (True, False)
    np.testing.assert_allclose(maps(web), maps(plain), atol=1e-5)
