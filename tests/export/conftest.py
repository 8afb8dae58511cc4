"""Exports are slow: each is made once, and so is each network's graph, for all test processes."""

import functools

import numpy as np
import onnx
import onnx_ir as ir
import onnxruntime as ort
import pytest
import torch
from onnx import TensorProto
from PIL import Image

from footprints_edge_export.convert import convert
from footprints_edge_export.graph.editing import to_proto
from footprints_edge_export.report import Conversion
from footprints_edge_models.networks.edge import EdgeNetwork
from footprints_edge_models.networks.reference import ReferenceNetwork

torch.set_num_threads(1)  # small pictures: threads cost more than they give

TRAINING = "nothing: random weights"


@pytest.fixture(scope="session")
def photos(tmp_path_factory):
    """A folder of ten small made-up photos: coloured blobs of many sizes, no two alike."""
    folder = tmp_path_factory.mktemp("photos")
    generator = torch.Generator().manual_seed(0)
    for index in range(10):
        picture = torch.zeros(3, 72, 104)
        for side in (3, 9, 26):
            noise = torch.rand(1, 3, side, side, generator=generator)
            picture += torch.nn.functional.interpolate(noise, (72, 104), mode="bicubic")[0] / 3
        pixels = (picture.clamp(0, 1) * 255).byte().permute(1, 2, 0).numpy()
        Image.fromarray(pixels).save(folder / f"{index}.png")
    return folder


@pytest.fixture(scope="session")
def edge_network():
    """An untrained edge network whose batch norms fit its weights, so that its maps vary."""
    torch.manual_seed(0)
    network = EdgeNetwork().train()
    for module in network.modules():
        if isinstance(module, torch.nn.BatchNorm2d):
            module.momentum = 1.0
            torch.nn.init.uniform_(module.weight, 0.7, 1.3)
            torch.nn.init.normal_(module.bias, 0, 0.2)
    with torch.no_grad():
        noise = torch.rand(4, 3, 12, 16)
        network(torch.nn.functional.interpolate(noise, (96, 128), mode="bicubic").clamp(0, 1))
    return network.eval()


@pytest.fixture(scope="session")
def edge_checkpoint(edge_network, tmp_path_factory):
    """Its state dict in a file."""
    path = tmp_path_factory.mktemp("edge") / "weights.pt"
    torch.save(edge_network.state_dict(), path)
    return path


@pytest.fixture(scope="session", autouse=True)
def _each_graph_once(graphs_once):
    """torch's exporter is most of what a conversion takes."""


@pytest.fixture(scope="session")
def rewritten():
    """The function that gives what a rewrite makes of a model."""

    def make(rewrite, model, *arguments):
        graph = ir.from_proto(model)
        rewrite(graph, *arguments)
        return to_proto(graph)

    return make


@pytest.fixture(scope="session")
def conversion():
    """The function that says what to make of a checkpoint, edge fp32 of any size by default."""

    def make(architecture="edge", size=None, precision="fp32", calibration=(), **options):
        defaults = {"target": "x86-vnni", "name": "test", "licence": None, "training": TRAINING}
        return Conversion(
            architecture=architecture,
            size=size,
            precision=precision,
            calibration=calibration,
            **defaults | options,
        )

    return make


@pytest.fixture(scope="session")
def converted(once, edge_checkpoint):
    """The function that converts the edge network in a folder of this name: file and report."""

    def give(name, wanted):
        def make(folder):
            path = folder / "edge.onnx"
            return path, convert(edge_checkpoint, path, wanted, overwrite=False)

        return once(name, make)

    return give


@pytest.fixture(scope="session")
def edge_fp32(converted, conversion):
    """The edge network for any size, in its own folder, and the report."""
    return converted("fp32", conversion())


SMALL = (64, 96)


@pytest.fixture(scope="session")
def edge_fixed(converted, conversion):
    """The edge network for (64, 96)."""
    return converted("fixed", conversion(size=SMALL))


@pytest.fixture(scope="session")
def mobile(converted, conversion):
    """The edge network for phones, float32, and its report."""
    return converted("mobile", conversion(size=SMALL, target="mobile"))


@pytest.fixture(scope="session")
def half(converted, conversion):
    """The edge network for the web with weights in half precision, and its report."""
    return converted("half", conversion(size=SMALL, target="web", precision="fp16"))


@pytest.fixture(scope="session")
def make_int8(converted, conversion, photos):
    """The function that gives the int8 file for (64, 96) and a kind of CPU, and its report."""

    @functools.cache
    def make(target):
        wanted = conversion(
            size=SMALL, precision="int8", calibration=(photos,), target=target, name="small"
        )
        return converted(f"int8-{target}", wanted)

    return make


@pytest.fixture(params=["x86-vnni", "x86-avx2", "arm64"])
def edge_int8(request, make_int8):
    """The edge network in int8, for each kind of CPU: file, report, kind."""
    return *make_int8(request.param), request.param


@pytest.fixture(scope="session")
def tiny_model(metadata):
    """The function that makes a tiny model of the contract, for tests to bend."""

    def make(size=("H", "W"), bias=(0.1, 0.2, 0.3, 0.4), props=None):
        weights = np.full((4, 3, 1, 1), 3 / 4096, np.float32)
        graph = onnx.helper.make_graph(
            [
                onnx.helper.make_node("Cast", ["image"], ["float"], to=TensorProto.FLOAT),
                onnx.helper.make_node("Transpose", ["float"], ["planes"], perm=[0, 3, 1, 2]),
                onnx.helper.make_node("Conv", ["planes", "weights", "bias"], ["maps"]),
            ],
            "tiny",
            [onnx.helper.make_tensor_value_info("image", TensorProto.UINT8, [1, *size, 3])],
            [onnx.helper.make_tensor_value_info("maps", TensorProto.FLOAT, [1, 4, *size])],
            [
                onnx.numpy_helper.from_array(weights, "weights"),
                onnx.numpy_helper.from_array(np.array(bias, np.float32), "bias"),
            ],
        )
        opsets = [onnx.helper.make_opsetid("", 18)]
        model = onnx.helper.make_model(graph, opset_imports=opsets, ir_version=10)
        onnx.helper.set_model_props(model, metadata.to_props() if props is None else props)
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
def running():
    """The function that loads a model, once, and gives its outputs for one input after another."""

    def load(model, **how):
        given = session(model, **how)
        return lambda feed: given.run(None, {given.get_inputs()[0].name: feed})

    return load


@pytest.fixture(scope="session")
def run(running):
    """The function that gives a model's outputs for one input."""

    def give(model, feed, **how):
        return running(model, **how)(feed)

    return give


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
        network(torch.nn.functional.interpolate(noise, (96, 128), mode="bicubic").clamp(0, 1))
    return network.eval()


@pytest.fixture(scope="session")
def reference_files(once, reference_network, conversion, photos):
    """Its checkpoint, and the files of it for one size: fp32 and int8."""

    def make(folder):
        made = {"checkpoint": folder / "model.pth"}
        torch.save(reference_network.state_dict(), made["checkpoint"])
        for precision in ("fp32", "int8"):
            calibration = (photos,) if precision == "int8" else ()
            wanted = conversion("reference", SMALL, precision, calibration)
            made[precision] = folder / f"{precision}.onnx"
            convert(made["checkpoint"], made[precision], wanted, overwrite=False)
        return made

    return once("reference", make)


@pytest.fixture
def optimised_nodes(tmp_path):
    """The function that gives the nodes that onnxruntime makes of a model file."""

    def nodes(path):
        session(str(path), write=tmp_path / "optimised.onnx")
        return list(onnx.load(tmp_path / "optimised.onnx").graph.node)

    return nodes
