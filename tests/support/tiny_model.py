"""A tiny model that honours the file contract, built on the fly; no trained weights needed."""

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper
from tiny_metadata import TINY

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
