import heapq
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from predictions import make_prediction

from footprints_edge.errors import NoPathError, OffGroundError, OutsideError, PlanningError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.geometry.ground_plane import GroundPlane
from footprints_edge.navigation import path_planning as planning
from footprints_edge.navigation.path_planning import STEP_COST

pytest.importorskip("skimage")

SIZE = (96, 128)
CAMERA = Intrinsics(100, 100, 63.5, 20.0)
HEIGHT_M, PITCH = 1.5, np.radians(20)


def world(probability, visible=None, times=1):
    """A level floor, 1.5 m below a camera that looks down by 20 degrees."""
    rows, columns = probability.shape
    y = (np.arange(rows) - CAMERA.cy) / CAMERA.fy
    down = np.cos(PITCH) * y + np.sin(PITCH)
    depth_m = np.repeat((HEIGHT_M / down).astype(np.float32)[:, None], columns, 1)
    picture = (times * rows, times * columns)
    return make_prediction(
        depth_m, ground=probability, visible_ground=visible, intrinsics=CAMERA, picture=picture
    )


def place_m(x, y):
    """Forward and left of a pixel of the floor, in closed form."""
    across, along = (np.asarray(x) - CAMERA.cx) / CAMERA.fx, (np.asarray(y) - CAMERA.cy) / CAMERA.fy
    depth_m = HEIGHT_M / (np.cos(PITCH) * along + np.sin(PITCH))
    forward = depth_m * (np.cos(PITCH) - np.sin(PITCH) * along)
    return np.stack([forward, -depth_m * across], axis=-1)


def cheapest(probability, start, goal):
    """Dijkstra in a few lines: the least cost from one (row, column) to another."""
    cost = np.where(probability > 0.5, 1 - probability + STEP_COST, np.inf)
    best, queue = {}, [(0.0, start)]
    while queue:
        so_far, (r, c) = heapq.heappop(queue)
        if (r, c) in best:
            continue
        best[r, c] = so_far
        for dr, dc in ((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j):
            at = (r + dr, c + dc)
            inside = 0 <= at[0] < cost.shape[0] and 0 <= at[1] < cost.shape[1]
            if inside and np.isfinite(cost[at]):
                step = np.hypot(dr, dc) * (cost[r, c] + cost[at]) / 2
                heapq.heappush(queue, (so_far + step, at))
    return best.get(goal)


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.floats(0.4, 0.9))
def test_no_path_is_cheaper_and_none_leaves_the_ground(seed, share):
    rng = np.random.default_rng(seed)
    probability = np.where(rng.random((14, 18)) < share, rng.uniform(0.5, 1, (14, 18)), 0.1)
    probability[-1, :6] = probability[-3, :6] = 0.9  # some plane, and two ends
    probability[0, -9:] = 0.9
    probability = probability.astype(np.float32)
    expected = cheapest(probability.astype(np.float64), (13, 0), (0, 17))
    prediction = world(probability)
    if expected is None:
        with pytest.raises(NoPathError, match="no path on ground connects"):
            prediction.plan((0, 13), (17, 0))
        return
    path = prediction.plan((0, 13), (17, 0))
    assert path.cost == pytest.approx(expected, rel=1e-5)
    columns, rows = np.rint(path.pixels).astype(int).T
    assert prediction.ground[rows, columns].all()
    assert (np.abs(np.diff(path.pixels, axis=0)).max(axis=1) == 1).all()
    np.testing.assert_array_equal(path.pixels[[0, -1]], [[0, 13], [17, 0]])
    assert prediction.plan((17, 0), (0, 13)).cost == pytest.approx(path.cost, rel=1e-5)


def test_a_path_in_metres_is_where_the_closed_form_says():
    path = world(np.ones(SIZE)).plan((20, 90), (110, 40))
    expected = place_m(*path.pixels.T)
    np.testing.assert_allclose(path.places_m, expected, atol=1e-3)
    steps = np.linalg.norm(np.diff(expected, axis=0), axis=1)
    assert path.length_m == pytest.approx(steps.sum(), rel=1e-3)


def test_metres_and_pixels_name_the_same_ends():
    prediction = world(np.ones(SIZE))
    ends_m = [place_m(30, 90), place_m(100, 50)]
    path = prediction.plan(*ends_m, unit="m")
    np.testing.assert_array_equal(path.pixels, prediction.plan((30, 90), (100, 50)).pixels)


def test_pixels_are_those_of_the_picture_not_of_the_maps():
    path = world(np.ones(SIZE), times=3).plan((31, 271), (301, 151))
    np.testing.assert_array_equal(path.pixels[[0, -1]], [[31, 271], [301, 151]])


@pytest.mark.parametrize("row", [30, 45, 65])
def test_the_margin_is_metres_near_and_far(row):
    probability = np.ones(SIZE)
    probability[row : row + 3, 50:80] = 0  # stands in the straight way
    start, goal = (65, 94), (65, row - 20)
    margin_m = 0.15
    prediction = world(probability)
    path = prediction.plan(start, goal, margin_m=margin_m)
    obstacle_rows, obstacle_columns = np.nonzero(probability == 0)
    # the obstacle's pixels reach half a pixel beyond their centres
    corners = [
        place_m(obstacle_columns + dx, obstacle_rows + dy)
        for dx, dy in ((0, 0), (0.5, 0), (-0.5, 0), (0, 0.5), (0, -0.5))
    ]
    between = path.places_m[:, None] - np.concatenate(corners)
    assert np.linalg.norm(between, axis=-1).min() >= margin_m - 1e-3
    assert path.length_m > prediction.plan(start, goal).length_m


@settings(max_examples=30)
@given(
    st.integers(0, 2**32 - 1),
    st.floats(0.02, 1.0),
    st.floats(-25, 25),
    st.sampled_from([0.3, 1.5, 4.0]),
)
def test_the_margin_closes_exactly_the_pixels_within_it(seed, margin_m, roll_deg, height_m):
    """Against all distances, for cameras that look down by up to 90 degrees and lean aside."""
    rng = np.random.default_rng(seed)
    pitch, roll = np.radians(rng.uniform(-5, 90)), np.radians(roll_deg)
    down = np.cos(pitch) * np.array([np.sin(roll), np.cos(roll), 0])
    plane = GroundPlane(-down - [0, 0, np.sin(pitch)], height_m, 0.0)
    small = Intrinsics(*rng.uniform(20, 60, 2), 15.5, rng.uniform(0, 20))
    walkable = rng.random((24, 32)) > rng.choice([0.02, 0.2])
    walkable[:, rng.integers(32) :] = True
    found = planning._near_obstacles(walkable, plane, small, margin_m)
    rows, columns = np.nonzero(walkable)
    places_m = plane.at_pixels(np.stack([columns, rows], axis=1).astype(float), small)
    across = np.argwhere(walkable[:, 1:] != walkable[:, :-1])[:, ::-1] + [0.5, 0]
    below = np.argwhere(walkable[1:] != walkable[:-1])[:, ::-1] + [0, 0.5]
    edges_m = plane.at_pixels(np.concatenate([across, below]), small)
    edges_m = edges_m[np.isfinite(edges_m).all(axis=1)]
    with np.errstate(invalid="ignore"):
        between_m = np.linalg.norm(places_m[:, None] - edges_m, axis=-1)
        expected = (between_m < margin_m).any(axis=1)
    np.testing.assert_array_equal(found[rows, columns], expected)
    assert not found[~walkable].any()


def test_a_gap_narrower_than_twice_the_margin_is_closed():
    probability = np.ones(SIZE)
    probability[58:60] = 0
    probability[58:60, 60:68] = 1  # at this depth a pixel is about 2 cm wide: 0.2 m
    prediction = world(probability)
    gap_m = np.linalg.norm(place_m(67.5, 59) - place_m(59.5, 59))
    assert prediction.plan((20, 90), (20, 40), margin_m=0.4 * gap_m).length_m > 0
    with pytest.raises(NoPathError, match="margin"):
        prediction.plan((20, 90), (20, 40), margin_m=0.6 * gap_m)


def test_hidden_ground_is_reported_and_can_be_avoided():
    visible = np.ones(SIZE)
    visible[60:70, :100] = 0
    prediction = world(np.ones(SIZE), visible)
    behind = prediction.plan((20, 90), (20, 40))
    assert behind.passes_hidden_ground
    rows = np.rint(behind.pixels[:, 1])
    np.testing.assert_array_equal(behind.hidden, (rows >= 60) & (rows < 70))
    around = prediction.plan((20, 90), (20, 40), ground="visible")
    assert not around.passes_hidden_ground
    assert around.length_m > behind.length_m


def test_invalid_ends_are_named():
    probability = np.ones(SIZE)
    probability[50:60, 50:60] = 0.1
    prediction = world(probability)
    with pytest.raises(OffGroundError, match=r"the start \(55\.0, 55\.0\) px is not on ground"):
        prediction.plan((55, 55), (20, 90))
    with pytest.raises(OffGroundError, match=r"the goal .* closer than margin_m=0\.2"):
        prediction.plan((20, 90), (61, 55), margin_m=0.2)
    with pytest.raises(
        OutsideError, match=r"the goal \(128\.0, 90\.0\) px is outside .* 128 x 96 px"
    ):
        prediction.plan((20, 90), (128, 90))
    with pytest.raises(OutsideError, match="start"):
        prediction.plan((-3, 0), (2, 0), unit="m")


@pytest.mark.parametrize(
    ("start", "options"),
    [
        ((1, 2, 3), {}),
        ((1, float("nan")), {}),
        ((20, 90), {"unit": "feet"}),
        ((20, 90), {"ground": "wet"}),
        ((20, 90), {"margin_m": -1}),
    ],
)
def test_nonsense_is_refused(start, options):
    with pytest.raises(PlanningError, match="give"):
        world(np.ones(SIZE)).plan(start, (30, 80), **options)


def test_a_missing_library_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "skimage.graph", None)
    with pytest.raises(PlanningError, match=r"footprints-edge\[plan\]"):
        planning.require_graph_search()
    with pytest.raises(PlanningError, match="skimage"):
        world(np.ones(SIZE)).plan((20, 90), (30, 80))
