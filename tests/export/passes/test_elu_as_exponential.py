"""ELU of plain operators is ELU."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from footprints_edge_export.passes.elu_as_exponential import elu_as_exponential


def graph(make_model, x, alphas):
    nodes = [
        ("Elu", [f"t{i}" if i else "x"], f"t{i + 1}", {"alpha": alpha})
        for i, alpha in enumerate(alphas)
    ]
    return make_model(nodes, {}, x, {f"t{len(alphas)}": np.float32})


@given(
    values=st.lists(st.floats(width=32, allow_nan=False, allow_infinity=True), min_size=1),
    count=st.integers(1, 3),
)
def test_every_number(make_model, run, values, count, rewritten):
    x = np.array(values, np.float32).reshape(1, 1, 1, -1)
    model = graph(make_model, x, [1.0] * count)
    faster = rewritten(elu_as_exponential, model)
    assert "Elu" not in {node.op_type for node in faster.graph.node}
    (expected,), (found,) = run(model, x), run(faster, x)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)
    np.testing.assert_array_equal(found[x >= 0], x[x >= 0])


def test_another_alpha_stays(make_model, rewritten):
    model = rewritten(
        elu_as_exponential, graph(make_model, np.zeros((1, 1, 1, 4), np.float32), [0.5, 1.0])
    )
    assert [node.op_type for node in model.graph.node if node.op_type == "Elu"] == ["Elu"]
