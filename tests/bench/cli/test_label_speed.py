"""`fp-bench label-speed`: labels by arrays are those of a plain loop over pixels."""

import json
from functools import partial

import pytest
from typer.testing import CliRunner

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_bench.cli import app
from footprints_edge_bench.latency import label_speed
from footprints_edge_bench.latency.label_speed import CAMERA, LabelCamera

pytest.importorskip("cv2", reason="labels are made with OpenCV")


def test_both_ways_agree_and_the_loop_is_slower(monkeypatch):
    """At half the sides, which takes a quarter of the time."""
    camera = LabelCamera((128, 224), Intrinsics(200, 200, 111.5, 63.5))
    small = partial(label_speed.measure_label_speed, camera, trials=3)
    monkeypatch.setattr(label_speed, "measure_label_speed", small)
    result = CliRunner().invoke(app, ["label-speed"])
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert CAMERA.size == (256, 448)
    assert (found["size"], found["neighbours"]) == ([128, 224], 10)
    assert found["same_ground_pixels"] == 1
    assert found["largest_difference_m"] == pytest.approx(0, abs=1e-5)
    assert found["footprint_iou"] > 0.9  # the loop's splats leave holes
    assert found["ratio"] > 5
