"""The paper's baselines in closed form."""

import json

import numpy as np
import pytest

from footprints_edge_bench.accuracy import baselines
from footprints_edge_bench.accuracy.baselines import BASELINES, ransac_depth_m, without_footprints
from footprints_edge_bench.accuracy.scoring import score
from footprints_edge_bench.geometry.boxes import Box, BoxesError, read_boxes
from footprints_edge_bench.geometry.convex_hull import convex_hull
from footprints_edge_bench.geometry.voxels import CLASSES, VoxelGrid, VoxelsError, read_voxels
from footprints_edge_bench.ground_truth.base import GroundTruth, LabelledMask

SIZE = (120, 160)
FLOOR, CHAIR, WALL = CLASSES.index("floor"), CLASSES.index("chair"), CLASSES.index("wall")


def in_camera(box_low, box_high, camera_to_world, turn_deg=0.0):
    """The box of the world between two corners, turned about its upright axis, in camera axes."""
    low, high = np.array(box_low, float), np.array(box_high, float)
    turn = np.radians(turn_deg)
    # length along the world's x, down, depth along y
    axes = np.array([[np.cos(turn), np.sin(turn), 0], [0, 0, -1], [-np.sin(turn), np.cos(turn), 0]])
    to_camera = np.linalg.inv(camera_to_world)
    centre = to_camera[:3, :3] @ (low + high) / 2 + to_camera[:3, 3]
    size = (high - low)[[0, 2, 1]]
    return Box(centre, size, to_camera[:3, :3] @ axes.T)


def test_hulls_of_known_shapes():
    ell = np.zeros((30, 30), bool)
    ell[5:25, 5:10] = ell[20:25, 5:25] = True
    hull = convex_hull(ell)
    rows, columns = np.mgrid[:30, :30]
    # Its slanted side leads from the corner of pixel (5, 9) to that of (20, 24): r - c = const.
    expected = (rows >= 5) & (rows < 25) & (columns >= 5) & (columns < 25) & (columns - rows <= 4)
    np.testing.assert_array_equal(hull, expected)
    np.testing.assert_array_equal(convex_hull(hull), hull)
    assert not convex_hull(np.zeros((4, 5), bool)).any()
    one = np.zeros((4, 5), bool)
    one[2, 3] = True
    np.testing.assert_array_equal(convex_hull(one), one)


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


def voxel_room(camera_to_world):
    """A floor of x -2 to 2, y 0 to 5 whose top is at z = 0; a chair above x 0 to 0.8, y 2 to 3;
    a wall across, at y = 1."""
    voxel_m = 0.1
    labels = np.zeros((40, 50, 22), np.uint8)
    labels[:, :, 0] = FLOOR
    labels[20:28, 20:30, 5] = CHAIR
    labels[:, 10, 1:] = WALL
    return VoxelGrid(labels, np.array([-2, 0, -voxel_m]), voxel_m, camera_to_world)


def test_floor_voxels_are_seen_through_everything(camera, pose, floor_of):
    view = pose(down_deg=40)
    points, depth_m = floor_of(view)
    x, y = points[..., 0], points[..., 1]
    found_m, clear = voxel_room(view).floor(camera, SIZE)

    def inside(margin_m):
        return (np.abs(x) < 2 - margin_m) & (y > margin_m) & (y < 5 - margin_m) & (depth_m > 0)

    surely, perhaps = inside(0.02), inside(-0.2)
    assert np.isfinite(found_m[surely]).all()
    assert not np.isfinite(found_m[~perhaps]).any()
    # half a voxel along the ray, at most
    np.testing.assert_allclose(found_m[surely], depth_m[surely], atol=0.06)

    def under_the_chair(margin_m):
        return (
            (x > margin_m) & (x < 0.8 - margin_m) & (y > 2 + margin_m) & (y < 3 - margin_m)
        ) & surely

    assert under_the_chair(0.06).sum() > 50
    assert not clear[under_the_chair(0.06)].any()
    assert clear[surely & ~under_the_chair(-0.06)].all()
    assert not clear[~np.isfinite(found_m)].any()


def test_a_grid_without_floor_shows_none(camera):
    grid = VoxelGrid(np.zeros((3, 3, 3), np.uint8), np.zeros(3), 1.0, np.eye(4))
    depth_m, clear = grid.floor(camera, SIZE)
    assert not np.isfinite(depth_m).any()
    assert not clear.any()


def test_voxels_are_read_as_they_are_described(tmp_path, camera, pose):
    grid = voxel_room(pose())
    path = tmp_path / "grid.npz"
    arrays = {k: getattr(grid, k) for k in ("labels", "origin_m", "voxel_m", "camera_to_grid")}
    np.savez(path, **arrays)
    for found, expected in zip(
        read_voxels(path).floor(camera, SIZE), grid.floor(camera, SIZE), strict=True
    ):
        np.testing.assert_array_equal(found, expected)
    np.savez(path, **arrays | {"class_names": ["floor", "rest"]})
    assert read_voxels(path).class_names == ("floor", "rest")
    np.savez(path, **arrays | {"origin_m": np.zeros(2)})
    with pytest.raises(VoxelsError, match=r"origin_m is \(2,\)"):
        read_voxels(path)
    np.savez(path, labels=grid.labels)
    with pytest.raises(VoxelsError, match=r"grid\.npz"):
        read_voxels(path)


def test_the_plane_s_depth_is_that_of_the_floor(camera, pose, floor_of):
    """Fitted to some noisy, partly wrong pixels at half the size; judged on all of them."""
    view = pose(roll_deg=8)
    _, depth_m = floor_of(view)
    half = camera.scaled(SIZE, (60, 80))
    rows, columns = np.mgrid[:60, :80].astype(float)
    x, y = (columns - half.cx) / half.fx, (rows - half.cy) / half.fy
    fall = (np.stack([x, y, np.ones_like(x)], -1) @ view[:3, :3].T)[..., 2]
    half_depth_m = np.where(fall < 0, -1.5 / fall, 0).astype(np.float32)
    ground = (half_depth_m > 0) & (half_depth_m < 5) & (columns < 50)
    wrong = ground & (rows > 55) & (columns < 20)
    half_depth_m[wrong] *= 0.6
    found_m = ransac_depth_m(half_depth_m, ground, half, SIZE, seed=0)
    below = depth_m > 0
    np.testing.assert_allclose(found_m[below], depth_m[below], rtol=1e-3)
    assert np.isinf(found_m[~below]).all()


def test_two_pixels_carry_no_plane(camera):
    ground = np.zeros(SIZE, bool)
    ground[50, 50:52] = True
    depth_m = np.ones(SIZE, np.float32)
    assert ransac_depth_m(depth_m, ground, camera, SIZE, seed=0) is None


@pytest.fixture
def crate(camera, pose, floor_of, predicted):
    """A crate on a floor: the prediction that sees all of it rightly, and the ground truth."""
    view = pose(down_deg=35)
    points, floor_m = floor_of(view)
    low, high = np.array([-0.12, 1.7, 0]), np.array([0.12, 1.9, 0.12])
    directions = (points - view[:3, 3]) / np.where(floor_m > 0, floor_m, 1)[..., None]
    with np.errstate(divide="ignore"):
        first, second = (low - view[:3, 3]) / directions, (high - view[:3, 3]) / directions
    enter = np.minimum(first, second).max(-1)
    leave = np.maximum(first, second).min(-1)
    hit = (enter < leave) & (enter > 0) & (floor_m > 0)
    near = (floor_m > 0) & (floor_m < 8)
    stands = (points[..., :2] > low[:2]).all(-1) & (points[..., :2] < high[:2]).all(-1) & near
    visible = near & ~hit
    visible_depth_m = np.where(hit, enter, np.where(near, floor_m, 50))
    prediction = predicted(visible, near & ~stands, visible_depth_m, np.where(near, floor_m, 50))
    everywhere = np.ones(SIZE, bool)
    ground_truth = GroundTruth(
        None,
        SIZE,
        camera,
        LabelledMask(visible, everywhere),
        LabelledMask(near & ~stands, everywhere),
        visible_depth_m.astype(np.float32),
        np.where(near & ~stands, floor_m, 0).astype(np.float32),
        convex_hull(visible),
        (in_camera(low, high, view),),
        None,
    )
    return prediction, ground_truth, stands


def test_rows_score_as_they_must_on_a_crate(crate):
    prediction, ground_truth, stands = crate
    scores = score({"Ours": prediction}, ground_truth, "a", boxes=ground_truth.boxes)
    assert list(scores) == [
        row for row in (*BASELINES, "Ours") if row not in (baselines.VOXELS, baselines.VOXELS_PLUS)
    ]
    freespace = {row: each.freespace.iou for row, each in scores.items() if each.freespace}
    footprint = {row: each.footprint.iou for row, each in scores.items() if each.footprint}
    assert freespace["Ours"] == footprint["Ours"] == 1
    assert freespace[baselines.BOXES] == footprint[baselines.BOXES] == 1
    assert freespace[baselines.NOTHING] == footprint[baselines.EVERYTHING] == 0
    true = ground_truth.ground.mask
    assert freespace[baselines.EVERYTHING] == pytest.approx(true.mean())
    # The hull of the visible floor covers the crate's footprint and all of the ground.
    hull = convex_hull(ground_truth.visible_ground.mask)
    assert freespace[baselines.HULL] == pytest.approx(true.sum() / (true | hull).sum())
    assert footprint[baselines.HULL] == 0
    seen = ground_truth.visible_ground.mask
    assert freespace[baselines.VISIBLE] == pytest.approx(seen.sum() / true.sum())
    assert footprint[baselines.VISIBLE] == pytest.approx(stands.sum() / (hull & ~seen).sum())
    # Depth alone tells where the near part of the crate stands.
    assert footprint[baselines.PROJECT_DOWN] > 0.3
    depth = {row: each.ground_depth for row, each in scores.items() if each.ground_depth}
    assert set(depth) == {baselines.RANSAC, baselines.ORACLE, "Ours"}
    for each in depth.values():
        assert each.a1 == 1
        assert each.rmse < 1e-3
    assert scores["Ours"].visible_ground.iou == scores["Ours"].visible_depth.a1 == 1
    assert scores[baselines.RANSAC].freespace is None


def test_voxels_of_a_dataset_make_their_rows(crate, pose):
    prediction, ground_truth, _ = crate
    grid = voxel_room(pose(down_deg=35))
    scores = score({"Ours": prediction}, ground_truth, "a", voxels=grid)
    assert scores[baselines.VOXELS].freespace.iou > 0.4
    assert scores[baselines.VOXELS].ground_depth.a1 > 0.4
    assert scores[baselines.VOXELS_PLUS].freespace != scores[baselines.VOXELS].freespace
    assert scores[baselines.VOXELS_PLUS].ground_depth is None


def test_baselines_start_from_the_first_model(crate, predicted):
    prediction, ground_truth, _ = crate
    blind = predicted(np.zeros(SIZE, bool))
    scores = score({"Ours": prediction, "Blind": blind}, ground_truth, "a")
    assert scores[baselines.HULL].freespace.predicted > 0
    scores = score({"Blind": blind, "Ours": prediction}, ground_truth, "a")
    assert scores[baselines.HULL].freespace.predicted == 0
    assert baselines.RANSAC not in scores  # nothing to fit a plane to
    assert baselines.ORACLE in scores
