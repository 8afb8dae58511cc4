"""Files that break the contract are refused, with the file's name and what is wrong."""

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper

from footprints_edge.errors import ModelError
from footprints_edge_export.errors import VerificationError
from footprints_edge_export.verification.contract import check_file


@pytest.fixture
def checked(tmp_path):
    """The function that writes a model and checks it."""

    def check(model):
        onnx.save(model, tmp_path / "a.onnx")
        check_file(tmp_path / "a.onnx")

    return check


def test_a_right_file_passes(tiny_model, checked):
    checked(tiny_model())
    checked(tiny_model((64, 96)))


def test_an_operator_of_another_domain(tiny_model, checked):
    model = tiny_model()
    model.graph.node[-1].output[0] = "linear"
    model.graph.node.append(
        helper.make_node("Gelu", ["linear"], ["maps"], domain="com.microsoft", name="gelu")
    )
    model.opset_import.append(helper.make_opsetid("com.microsoft", 1))
    with pytest.raises(VerificationError, match=r"a\.onnx.*com\.microsoft\.Gelu"):
        checked(model)


def test_an_opset_of_another_domain(tiny_model, checked):
    model = tiny_model()
    model.opset_import.append(helper.make_opsetid("ai.onnx.ml", 3))
    with pytest.raises(VerificationError, match=r"a\.onnx.*ai\.onnx\.ml"):
        checked(model)


def test_weights_outside_the_file(tiny_model, tmp_path):
    path = tmp_path / "a.onnx"
    onnx.save(tiny_model(), path, save_as_external_data=True, location="a.bin", size_threshold=0)
    assert (tmp_path / "a.bin").is_file()
    with pytest.raises(VerificationError, match=r"a\.onnx.*outside the file"):
        check_file(path)


def retyped(model, name, elem_type, shape):
    values = model.graph.input if name == "image" else model.graph.output
    del values[:]
    values.append(helper.make_tensor_value_info(name, elem_type, shape))
    return model


def test_a_float_input(tiny_model, checked):
    model = retyped(tiny_model(), "image", TensorProto.FLOAT, [1, "H", "W", 3])
    with pytest.raises(VerificationError, match=r"a\.onnx: input and output"):
        checked(model)


def test_an_output_of_another_name(tiny_model, checked):
    model = tiny_model()
    model.graph.node[-1].output[0] = model.graph.output[0].name = "depth"
    with pytest.raises(VerificationError, match=r"a\.onnx.*depth"):
        checked(model)


def test_a_second_output(tiny_model, checked):
    model = tiny_model()
    model.graph.output.append(
        helper.make_tensor_value_info("planes", TensorProto.FLOAT, [1, 3, "H", "W"])
    )
    with pytest.raises(VerificationError, match=r"a\.onnx.*planes"):
        checked(model)


def test_no_metadata(tiny_model, checked):
    with pytest.raises(ModelError, match=r"a\.onnx.*metadata"):
        checked(tiny_model(props={"author": "somebody"}))


@pytest.mark.parametrize("key", ["camera", "licence", "depth_range_m", "format"])
def test_a_missing_piece_of_metadata_is_named(tiny_model, checked, key):
    props = {p.key: p.value for p in tiny_model().metadata_props if not p.key.endswith(key)}
    with pytest.raises(ModelError, match=rf"footprints\.{key}"):
        checked(tiny_model(props=props))


@pytest.mark.parametrize("kind", ["text", "graph"])
def test_what_is_no_valid_onnx_is_a_failed_verification(tiny_model, tmp_path, kind):
    path = tmp_path / "a.onnx"
    if kind == "text":
        path.write_text("not a model")
    else:
        model = tiny_model()
        del model.graph.node[0]  # nobody makes `float` any more
        path.write_bytes(model.SerializeToString())
    with pytest.raises(VerificationError, match=r"a\.onnx"):
        check_file(path)


def test_nothing_of_the_file_is_changed(tiny_model, tmp_path):
    path = tmp_path / "a.onnx"
    onnx.save(tiny_model(bias=np.arange(4)), path)
    before = path.read_bytes()
    check_file(path)
    assert path.read_bytes() == before
