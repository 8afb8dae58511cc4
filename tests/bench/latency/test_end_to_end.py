"""Whole frames."""

from footprints_edge.model import load
from footprints_edge_bench.latency.end_to_end import end_to_end


def test_the_stages_of_the_whole_frame_add_up(green_is_ground):
    (found,) = end_to_end({"green": load(green_is_ground, threads=1)}, 5, (120, 160))
    assert list(found.stages_ms) == [
        "decode",
        "preprocess",
        "inference",
        "postprocess",
        "threshold",
    ]
    assert found.total.n == 5
    assert found.image_size == (120, 160)
    assert sum(found.stages_ms.values()) < 1.5 * found.total.p90_ms
