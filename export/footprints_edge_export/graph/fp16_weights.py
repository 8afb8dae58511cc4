"""Weights stored as half-precision floats: half the bytes, the same graph.

They are cast back to float32 when the file is loaded, so every engine can run it; one that
computes in half precision may drop the casts.
"""

import numpy as np
import onnx_ir as ir

from footprints_edge_export.errors import ExportError
from footprints_edge_export.graph.editing import NewNodes, add_constant, constant

SMALLEST = 256
"""Constants of fewer numbers, such as scales, stay float32: they are small and may need it."""


def store_weights_in_half(model: ir.Model) -> None:
    """Turn large float32 constants into float16 ones and a Cast, in place.

    Raises:
        ExportError: a weight is too large for half precision.
    """
    graph, first = model.graph, model.graph[0]
    for weight in list(graph.initializers.values()):
        values, name = constant(weight), str(weight.name)
        if values is None or values.dtype != np.float32 or values.size < SMALLEST:
            continue
        if np.abs(values).max() > np.finfo(np.float16).max:
            raise ExportError(
                f"a weight of {name} is {np.abs(values).max():g}, more than half precision "
                f"holds ({np.finfo(np.float16).max:g}); use --precision fp32"
            )
        half = add_constant(graph, f"{name}/half", values.astype(np.float16))
        single = NewNodes(first, name).add("Cast", [half], "float", to=ir.DataType.FLOAT)
        weight.replace_all_uses_with(single)
        del graph.initializers[name]
        single.name = name
