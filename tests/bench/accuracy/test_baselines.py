"""The baselines of the paper, in closed form."""

import numpy as np
import pytest
from baseline_shapes import in_camera, voxel_room

from footprints_edge_bench.accuracy import baselines
from footprints_edge_bench.accuracy.baselines import BASELINES, ransac_depth_m
from footprints_edge_bench.accuracy.scoring import score
from footprints_edge_bench.geometry.convex_hull import convex_hull
from footprints_edge_bench.ground_truth.base import GroundTruth, LabelledMask

SIZE = (120, 160)


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
