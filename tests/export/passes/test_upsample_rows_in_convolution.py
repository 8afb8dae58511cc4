"""A convolution of a doubled map, and of a map doubled in width only, give the same."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footprints_edge_export.passes.upsample_rows_in_convolution import upsample_rows_in_convolution


def graph(
    make_model, x, outputs, *, bias=True, bent=None, also=(), mode="reflect", scales=(1, 1, 2, 2)
):
    rng = np.random.default_rng(1)
    constants = {"weight": rng.normal(0, 1, (outputs, x.shape[1], 3, 3)).astype(np.float32)}
    if bias:
        constants["bias"] = rng.normal(0, 1, outputs).astype(np.float32)
    inputs = ["padded", *constants]
    constants |= {
        "scales": np.array(scales, np.float32),
        "pads": np.array([0, 0, 1, 1, 0, 0, 1, 1], np.int64),
    }
    resize = {
        "mode": "nearest",
        "nearest_mode": "floor",
        "coordinate_transformation_mode": "asymmetric",
    }
    nodes = [
        ("Resize", ["x", "", "scales"], "large", resize),
        ("Pad", ["large", "pads"], "padded", {"mode": mode}),
        ("Conv", inputs, "convolved", {"kernel_shape": [3, 3]}),
    ]
    results = dict.fromkeys(also, np.float32)
    if bent is not None:
        nodes.append(("Elu", ["convolved"], "bent", {"alpha": bent}))
        results["bent"] = np.float32
    else:
        nodes.append(("Neg", ["convolved"], "negative", {}))
        results["negative"] = np.float32
    return make_model(nodes, constants, x, results)


def kernel_sizes(model):
    return [
        list(attribute.ints)
        for node in model.graph.node
        for attribute in node.attribute
        if attribute.name == "kernel_shape"
    ]


@given(
    shape=st.tuples(st.just(1), st.integers(1, 5), st.integers(1, 6), st.integers(1, 6)),
    outputs=st.integers(1, 5),
    bias=st.booleans(),
    bent=st.sampled_from([None, 1.0, 0.5]),
    also=st.sets(st.sampled_from(["convolved", "padded", "large"])),
    free=st.booleans(),
)
def test_every_shape(make_model, run, shape, outputs, bias, bent, also, free, rewritten):
    x = np.random.default_rng(0).normal(0, 1, shape).astype(np.float32)
    model = graph(make_model, x, outputs, bias=bias, bent=bent, also=sorted(also))
    if free:
        for side, name in zip(
            model.graph.input[0].type.tensor_type.shape.dim[2:], "hw", strict=True
        ):
            side.dim_param = name
    faster = rewritten(upsample_rows_in_convolution, model)
    assert kernel_sizes(faster) == [[2, 3]]
    for found, expected in zip(run(faster, x), run(model, x), strict=True):
        assert found.shape == expected.shape
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-4)


@pytest.mark.parametrize("options", [{"mode": "edge"}, {"scales": (1, 1, 4, 2)}])
def test_another_pattern_stays(make_model, options, rewritten):
    model = graph(make_model, np.zeros((1, 2, 4, 4), np.float32), 3, **options)
    assert kernel_sizes(rewritten(upsample_rows_in_convolution, model)) == [[3, 3]]
