"""Pad and Resize on codes give, to the bit, what they gave on floats."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footprints_edge_export.passes.pad_and_resize_on_bytes import pad_and_resize_on_bytes

RESIZE = {
    "mode": "nearest",
    "nearest_mode": "floor",
    "coordinate_transformation_mode": "asymmetric",
}
steps = st.lists(
    st.one_of(
        st.just(("Elu",)),
        st.just(("quantize", 0)),
        st.just(("quantize", 1)),
        st.tuples(st.just("Resize"), st.integers(1, 3), st.integers(1, 2)),
        st.tuples(
            st.just("Pad"),
            st.sampled_from(["reflect", "edge", "constant"]),
            st.tuples(*[st.integers(0, 2)] * 4),
        ),
    ),
    max_size=7,
)


def chain(drawn, scales, dtype):
    """Nodes and constants that quantize, do what was drawn, and quantize again."""
    constants = {"scale0": np.float32(scales[0]), "scale1": np.float32(scales[1])}
    constants |= {"zero0": dtype(30), "zero1": dtype(5)}
    nodes, current = [], "x"

    def add(kind, inputs, **attributes):
        nonlocal current
        nodes.append((kind, [current, *inputs], f"t{len(nodes)}", attributes))
        current = nodes[-1][2]

    for step in [("quantize", 0), *drawn, ("quantize", 0)]:
        if step[0] == "quantize":
            add("QuantizeLinear", [f"scale{step[1]}", f"zero{step[1]}"])
            add("DequantizeLinear", [f"scale{step[1]}", f"zero{step[1]}"])
        elif step[0] == "Elu":
            add("Elu", [])
        elif step[0] == "Resize":
            constants[f"c{len(nodes)}"] = np.array([1, 1, *step[1:]], np.float32)
            add("Resize", ["", f"c{len(nodes)}"], **RESIZE)
        else:
            _, mode, (top, left, bottom, right) = step
            pads = np.array([0, 0, top, left, 0, 0, bottom, right], np.int64)
            constants[f"c{len(nodes)}"] = pads
            add("Pad", [f"c{len(nodes)}"], mode=mode)
    return nodes, constants, current


def moves_of_floats(model):
    """Resizes and Pads, other than constant ones, whose floats are quantized afterwards."""
    makers = {name: node for node in model.graph.node for name in node.output}
    sources = [
        makers.get(node.input[0]) for node in model.graph.node if node.op_type == "QuantizeLinear"
    ]
    return [
        node
        for node in sources
        if node is not None
        and (
            node.op_type == "Resize"
            or (node.op_type == "Pad" and node.attribute[0].s != b"constant")
        )
    ]


@given(
    drawn=steps,
    scales=st.tuples(st.floats(0.01, 0.1), st.floats(0.01, 0.1)),
    dtype=st.sampled_from([np.uint8, np.int8]),
    seed=st.integers(0, 9),
)
def test_every_chain_of_moves(make_model, run, drawn, scales, dtype, seed, rewritten):
    x = np.random.default_rng(seed).normal(0, 3, (1, 2, 5, 4)).astype(np.float32)
    nodes, constants, last = chain(drawn, scales, dtype)
    model = make_model(nodes, constants, x, {last: np.float32})
    faster = rewritten(pad_and_resize_on_bytes, model)
    assert moves_of_floats(faster) == []
    # As written: onnxruntime's optimiser itself merges one quantization with the next, inexactly.
    (expected,) = run(model, x, optimised=False)
    (found,) = run(faster, x, optimised=False)
    np.testing.assert_array_equal(found, expected)


def test_a_pad_between_equal_quantizations_needs_neither(make_model, rewritten):
    pads = ("Pad", "reflect", (1, 1, 1, 1))
    nodes, constants, last = chain([pads], (0.1, 0.1), np.uint8)
    model = make_model(nodes, constants, np.zeros((1, 2, 5, 4), np.float32), {last: np.float32})
    kinds = [node.op_type for node in rewritten(pad_and_resize_on_bytes, model).graph.node]
    assert kinds == ["QuantizeLinear", "Pad", "DequantizeLinear"]


@pytest.mark.parametrize("also", ["an output", "a float reader"])
def test_floats_that_are_wanted_stay(make_model, run, also, rewritten):
    x = np.random.default_rng(0).normal(0, 3, (1, 2, 5, 4)).astype(np.float32)
    nodes, constants, last = chain([("Pad", "reflect", (1, 1, 1, 1))], (0.1, 0.1), np.uint8)
    (padded,) = [node[2] for node in nodes if node[0] == "Pad"]
    results = {last: np.float32}
    if also == "an output":
        results[padded] = np.float32
    else:
        nodes.append(("Neg", [padded], "negative", {}))
        results["negative"] = np.float32
    model = make_model(nodes, constants, x, results)
    for found, expected in zip(
        run(rewritten(pad_and_resize_on_bytes, model), x), run(model, x), strict=True
    ):
        np.testing.assert_array_equal(found, expected)
