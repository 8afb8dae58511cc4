"""Multiply-accumulates from the profiler, counted against closed forms."""

import numpy as np

from footprints_edge_bench.engines.ort_profile import Operator, convolutions, operators, profile


def event(name, kind, start_us, spent_us, inputs, output):
    shapes = {"input_type_shape": inputs, "output_type_shape": [{"float": output}]}
    arguments = {"node_index": name, "op_name": kind, **shapes}
    names = {"name": f"{name}_kernel_time", "cat": "Node"}
    return {**names, "ts": start_us, "dur": spent_us, "args": arguments}


def test_events_become_operators():
    image, scale = {"uint8": [1, 8, 10, 3]}, {"float": []}
    events = [
        {"cat": "OnnxRuntimeEngine", "name": "model_run", "ts": 0, "dur": 9999, "args": {}},
        *(
            event("c", "QLinearConv", start, spent, [image, scale], [1, 4, 5, 16])
            for start, spent in ((0, 9000), (10_000, 300), (20_000, 100), (30_000, 200))
        ),
        *(
            event("j", "QLinearConcat", start, 50, [scale, {"uint8": [1]}, image], [1, 8, 10, 6])
            for start in (1, 10_001, 20_001, 30_001)
        ),
    ]
    conv, concat = operators(events, 3, {"c": [16, 3, 3, 3]})
    # The first frame does not count; of the others the median. 3x3x3 for each of 4x5x16 outputs.
    assert conv == Operator("QLinearConv", 0.2, 4 * 5 * 16 * 27, "uint8")
    assert concat == Operator("QLinearConcat", 0.05, 0, "uint8")
    assert conv.is_integer
    assert not concat.is_integer
    assert convolutions([conv, concat]) == {"int8": 1}


def test_a_real_profile_counts_the_convolution(green_is_ground):
    image = np.zeros((1, 32, 64, 3), np.uint8)
    found = profile(green_is_ground, {"image": image}, threads=1, frames=2)
    (conv,) = [each for each in found if each.is_convolution]
    # 1x1, 3 channels to 4; a kernel that lays channels out in blocks may pad the 4.
    exact = 32 * 64 * 3 * 4
    assert conv.macs >= exact
    assert conv.macs % exact == 0
    assert conv.ms > 0
    assert convolutions(found) == {"float32": 1}
