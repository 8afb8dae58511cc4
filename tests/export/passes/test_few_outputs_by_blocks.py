"""A head computed 2x2 pixels at a time gives the pixels it gave one at a time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footprints_edge_export.passes.few_outputs_by_blocks import few_outputs_by_blocks


def graph(make_model, x, outputs, kernel, pads, *, bias=True, dilation=1):
    rng = np.random.default_rng(1)
    constants = {"weight": rng.normal(0, 1, (outputs, x.shape[1], *kernel)).astype(np.float32)}
    if bias:
        constants["bias"] = rng.normal(0, 1, outputs).astype(np.float32)
    how = {"kernel_shape": kernel, "pads": pads, "dilations": [dilation] * 2}
    return make_model([("Conv", ["x", *constants], "y", how)], constants, x, {"y": np.float32})


def kinds(model):
    return [node.op_type for node in model.graph.node]


@given(
    inputs=st.integers(1, 20),
    outputs=st.integers(1, 4),
    kernel=st.tuples(st.integers(1, 4), st.integers(1, 4)),
    pads=st.tuples(*[st.integers(0, 1)] * 4),
    blocks=st.tuples(st.integers(2, 4), st.integers(2, 4)),
    bias=st.booleans(),
    free=st.booleans(),
)
def test_every_head_of_even_sides(
    make_model, run, inputs, outputs, kernel, pads, blocks, bias, free, rewritten
):
    sides = [2 * blocks[i] + kernel[i] - 1 - pads[i] - pads[i + 2] for i in range(2)]
    x = np.random.default_rng(0).normal(0, 1, (1, inputs, *sides)).astype(np.float32)
    model = graph(make_model, x, outputs, kernel, pads, bias=bias)
    if free:
        for side, name in zip(
            model.graph.input[0].type.tensor_type.shape.dim[2:], "hw", strict=True
        ):
            side.dim_param = name
    faster = rewritten(few_outputs_by_blocks, model)
    assert kinds(faster) == ["Conv", "DepthToSpace"]
    (expected,), (found,) = run(model, x), run(faster, x)
    assert expected.shape == (1, outputs, 2 * blocks[0], 2 * blocks[1])
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    ("outputs", "shape", "dilation"),
    [(5, (8, 8), 1), (2, (7, 8), 1), (2, (8, 7), 1), (2, (8, 8), 2)],
    ids=["many outputs", "odd height", "odd width", "dilated"],
)
def test_another_convolution_stays(make_model, outputs, shape, dilation, rewritten):
    x = np.zeros((1, 3, *shape), np.float32)
    model = graph(make_model, x, outputs, (3, 3), (dilation,) * 4, dilation=dilation)
    assert kinds(rewritten(few_outputs_by_blocks, model)) == ["Conv"]
