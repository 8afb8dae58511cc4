"""Which backends are measured."""

import pytest

from footprints_edge_bench.latency.backends import LatencyError, select_backends

SIZE = (64, 96)


def test_the_edge_network_has_no_coarser_heads():
    names = [row.name for row in select_backends(["-scale"], sizes=[SIZE])]
    assert names and all(name.startswith("reference") for name in names)


def test_only_takes_rows_by_their_names():
    names = [row.name for row in select_backends(["192x640 openvino"])]
    assert names == [
        "reference 192x640 openvino fp32",
        "reference 192x640 openvino bf16",
        "reference 192x640 openvino int8",
        "reference 192x640 openvino int8-nncf",
    ]
    with pytest.raises(LatencyError, match="matches no row"):
        select_backends(["nonsense"])
