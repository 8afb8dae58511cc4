"""Weights kept as half-precision floats: half the bytes, the same graph.

They are cast back to float32 where the file is loaded, so every engine can run it; one that
computes in half precision may drop the casts.
"""

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from footprints_edge_export.errors import ExportError

SMALLEST = 256
"""Fewer numbers than this, such as scales, stay float32: they weigh nothing and may need it."""


def store_weights_in_half(model: onnx.ModelProto) -> None:
    """Turn large float32 constants into float16 ones and a Cast, in place.

    Raises:
        ExportError: a weight is too large for half precision.
    """
    graph = model.graph
    casts = []
    for tensor in graph.initializer:
        values = numpy_helper.to_array(tensor)
        if values.dtype != np.float32 or values.size < SMALLEST:
            continue
        if np.abs(values).max() > np.finfo(np.float16).max:
            raise ExportError(
                f"a weight of {tensor.name} is {np.abs(values).max():g}, more than half precision "
                f"holds ({np.finfo(np.float16).max:g}); use --precision fp32"
            )
        name = tensor.name
        tensor.CopyFrom(numpy_helper.from_array(values.astype(np.float16), f"{name}/half"))
        casts.append(
            helper.make_node(
                "Cast", [f"{name}/half"], [name], name=f"{name}/float", to=TensorProto.FLOAT
            )
        )
    nodes = [*casts, *graph.node]
    del graph.node[:]
    graph.node.extend(nodes)
