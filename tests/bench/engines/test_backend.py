"""Descriptions of backends."""

from footprints_edge_bench.engines.backend import (
    describe_precisions,
)


def test_precisions_are_counted_most_first():
    assert describe_precisions({"float32": 4, "int8": 52}) == "int8 (52 convolutions; float32 4)"
    assert describe_precisions({"float32": 4}) == "float32 (4 convolutions)"
