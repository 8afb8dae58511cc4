"""Occupancy as arrays and points: the axes are in the file."""

import io

import numpy as np
import pytest
from predictions import make_prediction

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.navigation import occupancy_grid
from footprints_edge.navigation.occupancy_grid import UNKNOWN
from footprints_edge.outputs.occupancy_files import encode_occupancy_npz, encode_occupancy_ply

CAMERA = Intrinsics(100, 100, 63.5, 20.0)


def floor_with_a_box():
    """A level floor 1.5 m below the camera; a box hides a part of it."""
    depth_m = 1.5 / (np.cos(0.35) * (np.arange(96) - 20) / 100 + np.sin(0.35))
    depth_m = np.repeat(depth_m.astype(np.float32)[:, None], 128, 1)
    visible, seen_m = np.ones((96, 128)), depth_m.copy()
    visible[40:60, 50:70], seen_m[40:60, 50:70] = 0, depth_m[60, 0]
    return make_prediction(
        depth_m, visible_ground=visible, visible_depth_m=seen_m, intrinsics=CAMERA
    )


def test_the_arrays_are_the_interfaces_own():
    prediction = floor_with_a_box()
    grid, scan = prediction.top_down(), prediction.scan()
    with np.load(io.BytesIO(encode_occupancy_npz(prediction))) as arrays:
        np.testing.assert_array_equal(arrays["cells"], grid.cells)
        x_m, y_m = np.meshgrid(arrays["x_m"], arrays["y_m"], indexing="ij")
        np.testing.assert_allclose(np.dstack([x_m, y_m]), grid.places_m)
        np.testing.assert_array_equal(arrays["ranges_m"], scan.ranges_m)
        assert arrays["plane"][3] == grid.plane.camera_height_m
    assert np.isfinite(scan.ranges_m).any()


def test_the_points_are_the_known_cells():
    trimesh = pytest.importorskip("trimesh")
    prediction = floor_with_a_box()
    grid = prediction.top_down()
    cloud = trimesh.load(io.BytesIO(encode_occupancy_ply(prediction)), file_type="ply")
    known = grid.cells != UNKNOWN
    np.testing.assert_allclose(cloud.vertices[:, :2], grid.places_m[known], atol=1e-5)
    np.testing.assert_allclose(cloud.vertices[:, 2], 0)


def test_files_of_one_prediction_share_one_grid(tmp_path, monkeypatch):
    calls = []
    of = occupancy_grid.find_obstacles
    monkeypatch.setattr(
        occupancy_grid, "find_obstacles", lambda *given: calls.append(given) or of(*given)
    )
    prediction = floor_with_a_box()
    formats = ["topdown", "topdown_ply", "topdown_picture"]
    first = [path.read_bytes() for path in prediction.save(tmp_path / "a", formats, name="a")]
    assert len(calls) == 1
    again = floor_with_a_box().save(tmp_path / "b", formats[::-1], name="a")
    assert len(calls) == 2
    assert sorted(first) == sorted(path.read_bytes() for path in again)
