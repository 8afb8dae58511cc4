"""The whole frame beside its network."""

import math

from footprints_edge.model import load
from footprints_edge_bench.latency import whole_frame as module
from footprints_edge_bench.latency.whole_frame import whole_frame


def test_every_part_is_measured_and_the_folder_is_run(green_is_ground, monkeypatch):
    monkeypatch.setattr(module, "PHONE", (300, 400))
    monkeypatch.setattr(module, "FRAME", (72, 128))
    found = whole_frame(load(green_is_ground, threads=1), str(green_is_ground), 3, 2)
    assert 0 < found.network_ms < found.array_ms
    assert found.array_against_network.value == found.array_ms / found.network_ms
    assert found.jpeg_against_draft.value == found.jpeg_ms / found.draft_ms
    assert min(found.result_ms, found.folder_fps) > 0
    assert "128x72" in found.as_markdown()
    none = whole_frame(load(green_is_ground, threads=1), "", 2, 0)
    assert math.isnan(none.folder_fps)
