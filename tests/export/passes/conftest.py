"""Small graphs to rewrite."""

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper


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
