"""Boxes and their footprints, in closed form."""

import json

import numpy as np
import pytest
from baseline_shapes import in_camera

from footprints_edge_bench.accuracy.baselines import without_footprints
from footprints_edge_bench.geometry.boxes import BoxesError, read_boxes

SIZE = (120, 160)


@pytest.mark.parametrize("turn_deg", [0.0, 30.0])
@pytest.mark.parametrize("roll_deg", [0.0, 12.0])
def test_a_box_stands_on_its_footprint(camera, pose, floor_of, turn_deg, roll_deg):
    view = pose(roll_deg=roll_deg)
    box = in_camera((-0.4, 2.6, 0), (0.6, 3.2, 0.9), view, turn_deg)
    points, depth_m = floor_of(view)
    turn = np.radians(turn_deg)
    x, y = points[..., 0] - 0.1, points[..., 1] - 2.9
    along, across = (
        x * np.cos(turn) + y * np.sin(turn),
        y * np.cos(turn) - x * np.sin(turn),
    )
    expected = (np.abs(along) < 0.5) & (np.abs(across) < 0.3) & (depth_m > 0)
    assert expected.sum() > 300
    np.testing.assert_array_equal(box.footprint(camera, SIZE), expected)
    ground = np.ones(SIZE, bool)
    np.testing.assert_array_equal(without_footprints(ground, (box,), camera), ~expected)


def test_a_footprint_may_reach_behind_the_camera(camera, pose, floor_of):
    view = pose()
    box = in_camera((-0.5, -1, 0), (0.5, 3, 1), view)
    points, depth_m = floor_of(view)
    expected = (np.abs(points[..., 0]) < 0.5) & (points[..., 1] < 3) & (depth_m > 0)
    assert expected.any()
    np.testing.assert_array_equal(box.footprint(camera, SIZE), expected)
    behind = in_camera((-0.5, -3, 0), (0.5, -1, 1), view)
    assert not behind.footprint(camera, SIZE).any()


def test_boxes_are_read_as_they_are_described(tmp_path, camera, pose):
    box = in_camera((-0.4, 2.6, 0), (0.6, 3.2, 0.9), pose())
    entry = {k: getattr(box, k).tolist() for k in ("centre_m", "size_m", "rotation")}
    path = tmp_path / "boxes.json"
    path.write_text(json.dumps({"clip/a": [entry, entry], "clip/b": []}))
    read = read_boxes(path)
    assert {name: len(found) for name, found in read.items()} == {"clip/a": 2, "clip/b": 0}
    expected = box.footprint(camera, SIZE)
    np.testing.assert_array_equal(read["clip/a"][0].footprint(camera, SIZE), expected)


@pytest.mark.parametrize(
    "text",
    ["{", "[]", '{"a": [{"centre_m": [0, 0, 1]}]}', '{"a": [{"centre_m": 0, "size_m": 1}]}'],
)
def test_a_file_that_holds_no_boxes_is_refused(tmp_path, text):
    path = tmp_path / "boxes.json"
    path.write_text(text)
    with pytest.raises(BoxesError, match=r"boxes\.json"):
        read_boxes(path)
