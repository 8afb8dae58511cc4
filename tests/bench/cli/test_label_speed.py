"""`fp-bench label-speed`: labels by arrays are those of a plain loop over pixels."""

import json

import pytest
from typer.testing import CliRunner

from footprints_edge_bench.cli import app

pytest.importorskip("cv2", reason="labels are made with OpenCV")


def test_both_ways_agree_and_the_loop_is_slower():
    result = CliRunner().invoke(app, ["label-speed"])
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert (found["size"], found["neighbours"]) == ([256, 448], 10)
    assert found["same_ground_pixels"] == 1
    assert found["largest_difference_m"] == pytest.approx(0, abs=1e-5)
    assert found["footprint_iou"] > 0.9  # the loop's splats leave holes
    assert found["ratio"] > 5
