"""Codes doubled by Expand are codes doubled by Resize."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footprints_edge_export.passes.upsample_by_expanding import upsample_by_expanding


def graph(make_model, x, dtype, scales=(1, 1, 2, 2), nearest="floor"):
    constants = {
        "scale": np.float32(0.05),
        "zero": dtype(20),
        "scales": np.array(scales, np.float32),
    }
    how = {"nearest_mode": nearest, "coordinate_transformation_mode": "asymmetric"}
    nodes = [
        ("QuantizeLinear", ["x", "scale", "zero"], "codes", {}),
        ("Resize", ["codes", "", "scales"], "large", {"mode": "nearest", **how}),
        ("DequantizeLinear", ["large", "scale", "zero"], "y", {}),
    ]
    return make_model(nodes, constants, x, {"y": np.float32})


@given(
    shape=st.tuples(st.just(1), st.integers(1, 9), st.integers(1, 9), st.integers(1, 9)),
    dtype=st.sampled_from([np.uint8, np.int8]),
    free=st.booleans(),
)
def test_every_shape(make_model, run, shape, dtype, free, rewritten):
    x = np.random.default_rng(0).normal(0, 3, shape).astype(np.float32)
    model = graph(make_model, x, dtype)
    if free:
        for side in model.graph.input[0].type.tensor_type.shape.dim[2:]:
            side.dim_param = f"free{side.dim_value}"
    faster = rewritten(upsample_by_expanding, model)
    assert "Resize" not in {node.op_type for node in faster.graph.node}
    (expected,), (found,) = run(model, x), run(faster, x)
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(found, found[:, :, ::2, ::2].repeat(2, 2).repeat(2, 3))


@pytest.mark.parametrize("options", [{"scales": (1, 1, 3, 2)}, {"nearest": "ceil"}])
def test_another_resize_stays(make_model, options, rewritten):
    model = graph(make_model, np.zeros((1, 2, 3, 4), np.float32), np.uint8, **options)
    assert "Resize" in {node.op_type for node in rewritten(upsample_by_expanding, model).graph.node}
