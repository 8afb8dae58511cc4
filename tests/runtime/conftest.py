"""Tiny models that honour the file contract, built on the fly; no trained weights needed."""

from pathlib import Path

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper
from tiny_metadata import TINY
from videos import write_video

from footprints_edge.model import Model, load

# rows: visible ground = green, ground = red + green, visible disparity = blue, ground disparity
# = half of blue; all clipped to [0, 1]
COLOURS_TO_MAPS = np.array([[0, 1, 0], [1, 1, 0], [0, 0, 1], [0, 0, 0.5]], np.float32)


def tiny_model_bytes(size=("H", "W"), metadata=TINY, *, output="maps", props=None):
    """A model whose four maps are linear in the picture's colours."""
    weights = numpy_helper.from_array(COLOURS_TO_MAPS.reshape(4, 3, 1, 1) / 255, "weights")
    low, high = (numpy_helper.from_array(np.float32(v), n) for v, n in ((0, "low"), (1, "high")))
    graph = helper.make_graph(
        [
            helper.make_node("Cast", ["image"], ["float"], to=TensorProto.FLOAT),
            helper.make_node("Transpose", ["float"], ["planes"], perm=[0, 3, 1, 2]),
            helper.make_node("Conv", ["planes", "weights"], ["linear"]),
            helper.make_node("Clip", ["linear", "low", "high"], [output]),
        ],
        "tiny",
        [helper.make_tensor_value_info("image", TensorProto.UINT8, [1, *size, 3])],
        [helper.make_tensor_value_info(output, TensorProto.FLOAT, [1, 4, *size])],
        [weights, low, high],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=10)
    onnx.checker.check_model(model)
    helper.set_model_props(model, metadata.to_props() if props is None else props)
    return model.SerializeToString()


@pytest.fixture(scope="session")
def tiny_path(tmp_path_factory) -> Path:
    """A model file of free input size."""
    path = tmp_path_factory.mktemp("models") / "tiny.onnx"
    path.write_bytes(tiny_model_bytes())
    return path


@pytest.fixture(scope="session")
def tiny(tiny_path) -> Model:
    """The model of `tiny_path`, loaded."""
    return load(tiny_path, threads=1)


@pytest.fixture
def picture() -> np.ndarray:
    """uint8 (60, 100, 3): no symmetry; left green, middle red, right blue, over a ramp."""
    rgb = np.zeros((60, 100, 3), np.uint8)
    rgb[:, :40, 1] = 220
    rgb[30:, 40:70, 0] = 200
    rgb[..., 2] = np.linspace(20, 250, 100, dtype=np.uint8)
    rgb[:10, :15] = 250
    return rgb


@pytest.fixture
def model_bytes():
    """The function that makes tiny models."""
    return tiny_model_bytes


@pytest.fixture
def clip(tmp_path) -> Path:
    """A video of 20 shades at 10 frames per second."""
    pytest.importorskip("cv2")
    return write_video(tmp_path / "clip.avi")
