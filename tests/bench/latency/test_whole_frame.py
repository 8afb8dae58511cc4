"""The whole frame beside its network."""

import math
from pathlib import Path

import numpy as np
import pytest

from footprints_edge_bench.latency import whole_frame as module
from footprints_edge_bench.latency.whole_frame import WholeFrameError, as_markdown, whole_frame

CHECKOUT = Path(__file__).resolve().parents[3]
GREEN = np.full((72, 128, 3), (0, 255, 0), np.uint8)


@pytest.fixture(autouse=True)
def small(monkeypatch):
    monkeypatch.setattr(module, "PHONE", (300, 400))
    monkeypatch.setattr(module, "FRAME", (72, 128))


def test_every_part_is_measured_for_each_version(green_is_ground):
    counts = {"threads": 1, "trials": 3, "starts": 2, "photos": 2}
    runtimes = {"before": CHECKOUT, "here": None}
    both = whole_frame(runtimes, GREEN, str(green_is_ground), **counts)
    for found in both.values():
        assert 0 < found.network_ms < found.array_ms
        assert found.array_against_network.value == found.array_ms / found.network_ms
        assert found.jpeg_against_draft.value == found.jpeg_ms / found.draft_ms
        assert min(found.result_ms, found.resize_ms, found.folder_fps) > 0
        assert found.start.wall.value > 1
        assert found.start.peak_bytes > 20e6
    assert "| before | here |" in as_markdown(both)
    assert "128x72" in as_markdown(both)


def test_the_folder_may_be_left_out(green_is_ground):
    counts = {"threads": 1, "trials": 2, "starts": 2, "photos": 0}
    found = whole_frame({"here": None}, GREEN, str(green_is_ground), **counts)
    assert math.isnan(found["here"].folder_fps)


def test_a_version_that_fails_is_an_error(tmp_path):
    with pytest.raises(WholeFrameError):
        whole_frame({"here": None}, GREEN, str(tmp_path), threads=1, trials=2, starts=2, photos=0)
