"""Axes, frames and values of the messages, against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from predictions import make_prediction
from scipy.spatial.transform import Rotation

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.geometry.camera_pose import CameraPose, up_vector
from footprints_edge.geometry.ground_plane import GroundPlane
from footprints_edge.navigation.occupancy_grid import HIDDEN, OCCUPIED, VISIBLE, OccupancyGrid
from footprints_edge.navigation.range_scan import RangeScan
from footprints_edge.ros.ground_messages import (
    GroundOutput,
    grid_message,
    ground_messages,
    ground_transform,
    points_message,
    scan_message,
)
from footprints_edge.ros.messages import Header, Time

HEADER = Header(Time(12, 345), "front_optical_frame")
GROUND = Header(Time(12, 345), "camera_footprint")
CAMERA_M = 1.0


def level_ground(**changed):
    """A level camera 1 m above a floor without end: depth = f h / (v - cy) below the horizon."""
    camera = Intrinsics(100, 100, 79.5, 39.5)
    below = np.arange(80)[:, None] - camera.cy
    ground = np.repeat(below > 2, 160, axis=1)
    depth_m = np.repeat(np.where(below > 2, 100 * CAMERA_M / np.maximum(below, 1), 40), 160, axis=1)
    given = {"ground": ground, "intrinsics": camera, **changed}
    return make_prediction(depth_m, **given)


def cell_at(grid, x_m, y_m):
    """The value that a subscriber reads at a place of the grid's frame."""
    info = grid.info
    column = math.floor((x_m - info.origin.position.x) / info.resolution)
    row = math.floor((y_m - info.origin.position.y) / info.resolution)
    return grid.data.reshape(info.height, info.width)[row, column]


def messages_of(prediction, **options):
    return dict(ground_messages(prediction, HEADER, GroundOutput(**options)))


def test_a_known_pixel_is_a_known_cell():
    """Pixel (u, v) of the floor is x = f h / (v - cy) ahead and y = -x (u - cx) / f to the left.

    A patch of pixels is hidden ground; its cells, and no others, are hidden.
    """
    visible = np.ones((80, 160))
    visible[59:64, 120:131] = 0  # right of the middle
    prediction = level_ground()
    visible *= prediction.ground_probability
    grid = messages_of(level_ground(visible_ground=visible))["grid"]
    x_m = 100 * CAMERA_M / (61 - 39.5)
    y_m = -x_m * (125 - 79.5) / 100
    assert y_m < 0
    assert cell_at(grid, x_m, y_m) == 50
    assert cell_at(grid, x_m, -y_m) == 0
    assert cell_at(grid, x_m + 1, y_m) == cell_at(grid, x_m - 0.6, y_m) == 0
    assert cell_at(grid, 0.5, 0) == -1  # below the picture
    assert set(np.unique(grid.data)) == {-1, 0, 50}


def small_grid():
    cells = np.zeros((4, 8), np.uint8)
    cells[0, 1] = OCCUPIED  # far left: x 3.5 cells, y 2.5 cells
    cells[3, 6] = VISIBLE  # near right: x 0.5, y -2.5
    cells[2, 3] = HIDDEN  # x 1.5, y 0.5
    return OccupancyGrid(cells, 0.1, GroundPlane(np.array([0.0, -1, 0]), 1.0, 0.0))


@pytest.mark.parametrize(("hidden", "value"), [("cost", 50), ("unknown", -1), ("free", 0)])
def test_cells_are_where_rep_103_has_them(hidden, value):
    grid = grid_message(small_grid(), GROUND, hidden)
    assert (grid.info.width, grid.info.height, grid.info.resolution) == (4, 8, 0.1)
    assert cell_at(grid, 0.35, 0.25) == 100
    assert cell_at(grid, 0.05, -0.25) == 0
    assert cell_at(grid, 0.15, 0.05) == value
    assert np.count_nonzero(grid.data != -1) == 2 + (value != -1)
    assert grid.data.dtype == np.int8 and grid.data.shape == (32,)


def test_the_grid_is_what_a_map_server_makes_of_the_saved_map(tmp_path):
    """By nav2's map_server: `scale` maps darkness between the thresholds to 1 to 99."""
    from PIL import Image

    _, picture = small_grid().save(tmp_path / "map.yaml")
    grey, alpha = np.moveaxis(np.asarray(Image.open(picture), np.float64), -1, 0)
    darkness = (255 - grey) / 255
    value = np.rint(1 + 98 * (darkness - 0.196) / (0.65 - 0.196))
    value = np.where(darkness > 0.65, 100, np.where(darkness < 0.196, 0, value))
    value[alpha == 0] = -1
    served = value[::-1].astype(np.int8)  # its first row is the lowest y
    np.testing.assert_array_equal(served.ravel(), grid_message(small_grid(), GROUND).data)


def test_the_frames_are_those_of_the_picture_and_the_ground():
    got = messages_of(level_ground(), ground_frame="base_footprint")
    assert list(got) == ["tf", "grid", "scan", "points"]
    (transform,) = got["tf"].transforms
    assert transform.header == HEADER and transform.child_frame_id == "base_footprint"
    assert got["grid"].header == got["scan"].header == Header(Time(12, 345), "base_footprint")
    assert got["points"].header == HEADER


def test_a_picture_without_a_frame_has_one_in_the_tree():
    unnamed = dict(ground_messages(level_ground(), Header(Time(1, 2), "")))
    assert unnamed["points"].header.frame_id == "camera_optical_frame"
    assert unnamed["tf"].transforms[0].header.frame_id == "camera_optical_frame"


def test_what_is_not_wanted_is_not_made():
    assert list(messages_of(level_ground(), kinds=("scan",))) == ["tf", "scan"]


def test_without_a_plane_only_the_points_are_known():
    assert list(messages_of(level_ground(ground=np.zeros((80, 160))))) == ["points"]


def test_a_pose_that_is_known_makes_a_static_transform():
    known = replace(level_ground(), pose=CameraPose(0.7, 12.0, -3.0))
    assert "tf_static" in messages_of(known) and "tf" not in messages_of(known)
    partly = replace(level_ground(), pose=CameraPose(1.0))
    assert "tf" in messages_of(partly)


@pytest.mark.parametrize(
    ("pitch", "roll"), [(0, 0), (20, 0), (-10, 15), (35, -120), (0, 180), (89, 0), (90, 0)]
)
def test_the_transform_takes_the_ground_to_the_optical_frame(pitch, roll):
    """The library's rotation of the quaternion does what `GroundPlane.to_ground` undoes."""
    plane = GroundPlane(up_vector(pitch, roll), 1.3, 0.0)
    (stamped,) = ground_transform(plane, HEADER, "camera_footprint").transforms
    q, t = stamped.transform.rotation, stamped.transform.translation
    rotation = Rotation.from_quat([q.x, q.y, q.z, q.w])
    on_ground = np.random.default_rng(0).normal(size=(20, 3))
    optical = rotation.apply(on_ground) + np.array([t.x, t.y, t.z])
    np.testing.assert_allclose(plane.to_ground(optical), on_ground, atol=1e-9)


def test_the_transform_of_a_level_camera_in_closed_form():
    """1.3 m above the ground: forward is z, left is -x, up is -y."""
    plane = GroundPlane(np.array([0.0, -1, 0]), 1.3, 0.0)
    (stamped,) = ground_transform(plane, HEADER, "camera_footprint").transforms
    t, q = stamped.transform.translation, stamped.transform.rotation
    np.testing.assert_allclose([t.x, t.y, t.z], [0, 1.3, 0], atol=1e-12)
    np.testing.assert_allclose([q.x, q.y, q.z, q.w], [0.5, -0.5, 0.5, 0.5], atol=1e-12)


def test_a_post_is_at_its_bearing_and_range_in_the_scan():
    """A post 3 m ahead, whose pixels stand at u = 99.5 to 105: 11.3 to 14.3 degrees right."""
    prediction = level_ground()
    depth_m = prediction.unmasked_ground_depth_m.copy()
    visible = prediction.ground_probability.copy()
    post = np.s_[30:70, 100:106]
    depth_m[:42] = 60  # beyond what a scan reaches
    depth_m[post], visible[post] = 3.0, 0
    seen = level_ground(visible_depth_m=depth_m, visible_ground=visible)
    scan = messages_of(seen)["scan"]
    assert (scan.angle_min, scan.angle_max) == pytest.approx((-math.pi / 2, math.pi / 2))
    assert len(scan.ranges) == len(scan.intensities) == 181
    angle = scan.angle_min + np.arange(181) * scan.angle_increment
    hit = np.isfinite(scan.ranges)
    assert hit.any()
    bearing = -np.degrees(np.arctan2(np.array([100, 105]) - 79.5, 100))
    assert bearing[1] - 1 <= np.degrees(angle[hit]).min() <= np.degrees(angle[hit]).max()
    assert np.degrees(angle[hit]).max() <= bearing[0] + 1
    np.testing.assert_allclose(scan.ranges[hit], 3 * np.hypot(1, 0.23), rtol=0.1)
    assert np.all((scan.ranges[hit] > scan.range_min) & (scan.ranges[hit] < scan.range_max))
    assert np.isnan(scan.ranges[[0, -1]]).all()  # not in view
    assert np.isinf(scan.ranges[90])  # clear
    assert np.all((scan.intensities[hit] > 0) & (scan.intensities[hit] < 1))


def test_the_increment_is_that_of_the_bearings():
    ranges = RangeScan(np.array([-10.0, 0, 10]), np.ones(3, np.float32), np.ones(3, np.float32))
    assert scan_message(ranges, GROUND).angle_increment == pytest.approx(math.radians(10))


def test_points_are_the_surfaces_in_the_optical_frame_with_their_colours():
    picture = np.random.default_rng(0).integers(0, 255, (80, 160, 3), np.uint8)
    visible = np.ones((80, 160))
    visible[60:64, 120:130] = 0
    visible *= level_ground().ground_probability
    prediction = level_ground(picture=picture, visible_ground=visible)
    cloud = points_message(prediction, HEADER)
    names = [field.name for field in cloud.fields]
    assert names == ["x", "y", "z", "rgb", "layer"]
    kinds = {7: "<f4", 2: "u1"}
    dtype = np.dtype(
        {
            "names": names,
            "formats": [kinds[field.datatype] for field in cloud.fields],
            "offsets": [field.offset for field in cloud.fields],
            "itemsize": cloud.point_step,
        }
    )
    points = np.frombuffer(cloud.data.tobytes(), dtype)
    assert len(points) == cloud.width and cloud.height == 1
    assert cloud.row_step == cloud.width * cloud.point_step == len(cloud.data)
    seen, hidden = points[points["layer"] == 0], points[points["layer"] == 1]
    assert len(seen) == 40 * 80 and len(hidden) == 2 * 5
    u, v = 40, 70
    point = seen[(v // 2) * 80 + u // 2]
    depth_m = 100 / (v - 39.5)
    expected = (depth_m * (u - 79.5) / 100, depth_m * (v - 39.5) / 100, depth_m)
    assert (point["x"], point["y"], point["z"]) == pytest.approx(expected, rel=1e-5)
    packed = int(point["rgb"].view(np.uint32))
    assert [packed >> 16, packed >> 8 & 255, packed & 255] == picture[v, u].tolist()
    np.testing.assert_allclose(hidden["y"], CAMERA_M, rtol=1e-5)  # on the floor
