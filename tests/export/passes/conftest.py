"""Small graphs to rewrite, and the reference network with activations as large as real ones."""

import numpy as np
import onnx
import onnxruntime as ort
import pytest
import torch
from onnx import TensorProto, helper, numpy_helper

from footprints_edge_export.convert import convert
from footprints_edge_models.networks.reference import ReferenceNetwork

SIZE = (96, 128)


@pytest.fixture(scope="session")
def make_model():
    """The function that makes a checked model of one input `x` and outputs of unknown size."""

    def make(nodes, constants, x, results):
        types = {np.dtype(np.float32): TensorProto.FLOAT, np.dtype(np.uint8): TensorProto.UINT8}
        types[np.dtype(np.int8)] = TensorProto.INT8
        graph = helper.make_graph(
            [
                helper.make_node(kind, inputs, [output], **attributes)
                for kind, inputs, output, attributes in nodes
            ],
            "made",
            [helper.make_tensor_value_info("x", types[x.dtype], x.shape)],
            [
                helper.make_tensor_value_info(name, types[np.dtype(dtype)], [None] * 4)
                for name, dtype in results.items()
            ],
            [numpy_helper.from_array(np.asarray(value), name) for name, value in constants.items()],
        )
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=10)
        onnx.checker.check_model(model, full_check=True)
        return model

    return make


def session(model, *, optimised=True, write=None):
    options = ort.SessionOptions()
    options.log_severity_level = 4
    options.intra_op_num_threads = 1
    if not optimised:
        options.graph_optimization_level = ort.GraphOptimizationLevel.ORT_DISABLE_ALL
    if write:
        options.optimized_model_filepath = str(write)
    return ort.InferenceSession(
        model if isinstance(model, str) else model.SerializeToString(),
        options,
        providers=["CPUExecutionProvider"],
    )


@pytest.fixture(scope="session")
def run():
    """The function that gives a model's outputs for one input."""

    def give(model, feed, **how):
        given = session(model, **how)
        return given.run(None, {given.get_inputs()[0].name: feed})

    return give


@pytest.fixture
def optimised_nodes(tmp_path):
    """The function that gives the nodes that onnxruntime makes of a model file."""

    def nodes(path):
        session(str(path), write=tmp_path / "optimised.onnx")
        return list(onnx.load(tmp_path / "optimised.onnx").graph.node)

    return nodes


@pytest.fixture(scope="session")
def reference_network():
    """The reference network, untrained, its activations of unit size: maps that vary.

    With torch's own first weights they shrink from layer to layer to nothing.
    """
    torch.manual_seed(0)
    network = ReferenceNetwork().train()
    for name, module in network.named_modules():
        if isinstance(module, torch.nn.BatchNorm2d):
            module.momentum = 1.0
        if isinstance(module, torch.nn.Conv2d) and "decoder" in name:
            torch.nn.init.kaiming_normal_(module.weight, nonlinearity="relu")
            torch.nn.init.normal_(module.bias, 0, 0.1)
            if module.out_channels == 2:
                module.weight.data *= 0.3
    with torch.no_grad():
        noise = torch.rand(4, 3, 12, 16)
        network(torch.nn.functional.interpolate(noise, SIZE, mode="bicubic").clamp(0, 1))
    return network.eval()


@pytest.fixture(scope="session")
def reference_files(reference_network, conversion, photos, tmp_path_factory):
    """Its checkpoint, and the files of it for one size: fp32 and int8."""
    folder = tmp_path_factory.mktemp("reference")
    checkpoint = folder / "model.pth"
    torch.save(reference_network.state_dict(), checkpoint)
    made = {"checkpoint": checkpoint}
    for precision in ("fp32", "int8"):
        wanted = conversion("reference", SIZE, precision, (photos,) if precision == "int8" else ())
        made[precision] = folder / f"{precision}.onnx"
        convert(checkpoint, made[precision], wanted, overwrite=False)
    return made
