"""What a model file may hold, before an engine sees it."""

from contextlib import suppress

import numpy as np
import onnx
import pytest
from hypothesis import given
from hypothesis import strategies as st
from onnx import TensorProto, helper, numpy_helper

import footprints_edge as fp
from footprints_edge.model_files import registry
from footprints_edge.model_files.graph_check import check_graph
from footprints_edge.model_files.read import MAX_BYTES, read_model_file


@pytest.fixture
def model(model_bytes):
    """A model of the contract, to be spoiled."""
    return onnx.load_from_string(model_bytes())


def spoil(model, node, *constants):
    """Puts a node before the last one."""
    model.graph.node.insert(len(model.graph.node) - 1, node)
    model.graph.initializer.extend(constants)
    return model.SerializeToString()


def constant(values, name, kind=np.int64):
    return numpy_helper.from_array(np.array(values, kind), name)


def refusal(data):
    with pytest.raises(ValueError) as caught:
        check_graph(data)
    return str(caught.value)


def test_files_of_the_contract_pass(model_bytes):
    check_graph(registry.resolve().read_bytes())
    check_graph(model_bytes())
    check_graph(model_bytes((32, 64)))


@pytest.mark.parametrize("operator", ["RandomNormalLike", "Loop", "If", "ConstantOfShape", "Tile"])
def test_other_operators_are_named(operator, model):
    assert operator in refusal(spoil(model, helper.make_node(operator, ["linear"], ["more"])))


def test_operators_of_other_makers_are_named(model):
    node = helper.make_node("Conv", ["linear", "weights"], ["more"], domain="com.microsoft.nchwc")
    assert "com.microsoft.nchwc.Conv" in refusal(spoil(model, node))


@pytest.mark.parametrize("version", [2**63 - 1, 10_000_000, 0, -1])
def test_versions_of_operators_that_will_never_be_are_refused(version, model):
    model.opset_import[0].version = version  # OpenVINO would look for each, from there down
    assert f"version {version}" in refusal(model.SerializeToString())


def test_functions_are_refused(model):
    opset = helper.make_opsetid("x", 1)
    function = helper.make_function("x", "F", ["a"], ["b"], [], [opset])
    model.functions.append(function)
    assert "functions" in refusal(model.SerializeToString())


def test_subgraphs_are_refused(model):
    inner = helper.make_graph([], "inner", [], [])
    assert "graph" in refusal(spoil(model, helper.make_node("Abs", ["linear"], ["b"], body=inner)))


def test_weights_in_another_file_are_refused(model):
    weights = model.graph.initializer[0]
    weights.ClearField("raw_data")
    weights.data_location = TensorProto.EXTERNAL
    weights.external_data.add(key="location", value="/etc/passwd")
    assert "another file" in refusal(model.SerializeToString())


@pytest.mark.parametrize("dims", [[2**31, 2**31], [2**62, 4], [-1], [0], [4, 3, 1, 2], [1] * 9])
def test_dims_must_agree_with_the_bytes(dims, model):
    del model.graph.initializer[0].dims[:]
    model.graph.initializer[0].dims.extend(dims)
    assert "shape" in refusal(model.SerializeToString())


@pytest.mark.parametrize(
    ("node", "values"),
    [
        (helper.make_node("Expand", ["linear", "n"], ["b"]), [1, 4, 30000, 30000]),
        (helper.make_node("Expand", ["linear", "n"], ["b"]), [2**62]),
        (helper.make_node("Pad", ["linear", "n"], ["b"]), [0, 0, 0, 0, 0, 0, 4000, 4000]),
        (helper.make_node("Resize", ["linear", "", "n"], ["b"]), [1.0, 1.0, 1e4, 1e4]),
        (helper.make_node("DepthToSpace", ["linear"], ["b"], blocksize=0), []),
        (helper.make_node("MaxPool", ["linear"], ["b"], kernel_shape=[0, 0]), []),
        (helper.make_node("Elu", ["linear"], ["b"], alpha=float("nan")), []),
        (helper.make_node("Conv", ["linear"], ["b"]), []),
        (helper.make_node("Constant", [], ["b"], value_int=2**40), []),
    ],
)
def test_what_would_fill_the_memory_or_stop_an_engine_is_refused(node, values, model):
    kind = np.float32 if node.op_type == "Resize" else np.int64
    refusal(spoil(model, node, constant(values, "n", kind)))


def test_the_end_of_a_slice_may_be_far(model):
    ends = [constant([n], name) for n, name in ((0, "begin"), (2**63 - 1, "end"), (3, "axis"))]
    check_graph(
        spoil(model, helper.make_node("Slice", ["linear", "begin", "end", "axis"], ["b"]), *ends)
    )


def test_a_circle_is_refused(model):
    model.graph.node[2].input[0] = "maps"
    assert "too early" in refusal(model.SerializeToString())


def test_a_value_is_made_once(model):
    assert "twice" in refusal(spoil(model, helper.make_node("Abs", ["planes"], ["linear"])))


def test_texts_are_utf8_and_short(model):
    model.metadata_props.add(key="footprints.more", value="x" * 10**6)
    assert "1000000 bytes" in refusal(model.SerializeToString())
    spoiled = model.SerializeToString().replace(b"x" * 10**6, b"\x80" * 10**6)
    refusal(spoiled)


@given(st.data())
def test_any_bytes_are_checked_or_refused(data):
    whole = registry.resolve().read_bytes()[-3000:]
    at = data.draw(st.integers(0, len(whole) - 1))
    spoiled = (
        whole[:at] + data.draw(st.binary(max_size=20)) + whole[at + data.draw(st.integers(0, 9)) :]
    )
    for content in (spoiled, whole[:at]):
        with suppress(ValueError):
            check_graph(content)


def test_a_refused_file_is_named_with_its_hash(tmp_path, model):
    path = tmp_path / "loop.onnx"
    path.write_bytes(spoil(model, helper.make_node("Loop", ["linear"], ["more"])))
    with pytest.raises(fp.ModelError, match=r"loop\.onnx.*sha256 [0-9a-f]{64}.*'Loop'"):
        fp.load(path)


def test_a_file_without_end_is_refused(tmp_path):
    path = tmp_path / "long.onnx"
    with path.open("wb") as file:
        file.truncate(MAX_BYTES + 1)
    with pytest.raises(fp.ModelError, match="larger than"):
        read_model_file(path)


def test_a_damaged_bundled_file_is_never_parsed(tmp_path, monkeypatch):
    entry = registry.bundled_models()[0]
    (tmp_path / "models.json").write_bytes((registry.DATA / "models.json").read_bytes())
    (tmp_path / entry.path.name).write_bytes(b"\x0a" + entry.path.read_bytes()[1:])
    monkeypatch.setattr(registry, "DATA", tmp_path)
    with pytest.raises(fp.ModelError, match=r"bundled model .* is damaged"):
        fp.load()
