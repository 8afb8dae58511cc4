import heapq
import sys

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from predictions import make_prediction

from footprints_edge.errors import NoPathError, OffGroundError, OutsideError, PlanningError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.navigation import path_planning as planning
from footprints_edge.navigation.occupancy_grid import OCCUPIED, OccupancyGrid
from footprints_edge.navigation.path_planning import STEP_COST

pytest.importorskip("scipy")

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


def cheapest(cost, start, goal):
    """Dijkstra in a few lines: the least cost from one (row, column) to another; None without."""
    best, queue = {}, [(0.0, start)]
    while queue:
        so_far, (r, c) = heapq.heappop(queue)
        if (r, c) in best:
            continue
        best[r, c] = so_far
        for dr, dc in ((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j):
            at = (r + dr, c + dc)
            inside = 0 <= at[0] < cost.shape[0] and 0 <= at[1] < cost.shape[1]
            if inside and min(cost[at], cost[r, at[1]], cost[at[0], c]) >= 0:
                step = np.hypot(dr, dc) * (cost[r, c] + cost[at]) / 2
                heapq.heappush(queue, (so_far + step, at))
    return best.get(goal)


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.floats(0.4, 0.9))
def test_no_route_through_the_grid_is_cheaper(seed, share):
    rng = np.random.default_rng(seed)
    cost = np.where(rng.random((14, 18)) < share, rng.uniform(0.01, 0.5, (14, 18)), -1)
    cost[13, 0] = cost[0, 17] = 0.1
    expected = cheapest(cost, (13, 0), (0, 17))
    route, found = planning.cheapest_route(cost, (13, 0), (0, 17))
    if expected is None:
        assert route is None
        return
    assert found == pytest.approx(expected, rel=1e-5)
    assert (np.abs(np.diff(route, axis=0)).max(axis=1) == 1).all()


def test_no_route_slips_between_two_closed_cells_that_meet_in_a_corner():
    cost = np.full((6, 9), 0.1)
    cost[range(5), range(2, 7)] = -1  # a slanting wall, open at the bottom
    route, found = planning.cheapest_route(cost, (1, 1), (1, 5))
    assert route[:, 0].max() == 5
    assert found == pytest.approx(cheapest(cost, (1, 1), (1, 5)))
    cost[5, 7] = -1
    assert planning.cheapest_route(cost, (1, 1), (1, 5))[0] is None


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_a_path_touches_no_closed_cell_not_even_at_its_corner(seed):
    rng = np.random.default_rng(seed)
    cost = np.where(rng.random((14, 18)) < 0.8, rng.choice([0.1, 0.2], (14, 18)), -1)
    cost[13, 0] = cost[0, 17] = 0.1
    route, _ = planning.cheapest_route(cost, (13, 0), (0, 17))
    if route is None:
        return
    cell_m = 0.05
    grid = OccupancyGrid(np.zeros(cost.shape, np.uint8), cell_m, None)
    corners_m = planning._shortened(grid.places_m[route[:, 0], route[:, 1]], cost, grid)
    points = np.array([14, 9]) - planning._dense(corners_m, cell_m / 100) / cell_m
    for aside in ([1e-6, 1e-6], [1e-6, -1e-6], [-1e-6, 1e-6], [-1e-6, -1e-6]):
        row, column = np.floor(points + aside).astype(int).T
        assert (cost[row, column] >= 0).all()


@pytest.mark.parametrize("goal", [(110, 40), (64, 30), (5, 60), (127, 70)])
def test_over_open_ground_a_path_is_the_straight_line(goal):
    path = world(np.ones(SIZE)).plan((20, 90), goal)
    ends_m = place_m(np.array([20, goal[0]]), np.array([90, goal[1]]))
    straight_m = np.linalg.norm(ends_m[1] - ends_m[0])
    np.testing.assert_allclose(path.places_m[[0, -1]], ends_m, atol=1e-3)
    assert path.length_m == pytest.approx(straight_m, rel=1e-3)
    assert path.cost == pytest.approx(STEP_COST * straight_m, rel=1e-2)
    np.testing.assert_allclose(path.places_m, place_m(*path.pixels.T), atol=1e-3)
    assert np.linalg.norm(np.diff(path.places_m, axis=0), axis=1).max() < 0.051


def among_pillars(rng):
    """A floor with six pillars."""
    probability = np.ones(SIZE)
    for x, y in zip(rng.integers(10, 110, 6), rng.integers(32, 75, 6), strict=True):
        probability[y : y + 6, x : x + 12] = 0
    probability[85:, :] = probability[:30] = 1
    return probability


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
@example(22)
@example(29)
def test_a_path_that_begins_beside_an_obstacle_goes_round_it_all_the_same(seed):
    rng = np.random.default_rng(seed)
    prediction = world(among_pillars(rng))
    floor = np.argwhere(prediction.ground & (np.arange(SIZE[0]) > 26)[:, None])[:, ::-1]
    for start, goal in rng.choice(floor, (3, 2)):
        try:
            path = prediction.plan(start, goal)
        except (NoPathError, OffGroundError):
            continue
        assert np.isfinite(path.cost)  # infinite where a line leads over what is closed


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_a_path_never_leaves_the_ground(seed):
    """Among pillars; a path touches no pixel of one by more than half a cell."""
    probability = among_pillars(np.random.default_rng(seed))
    prediction = world(probability)
    try:
        path = prediction.plan((64, 92), (64, 28))
    except NoPathError:
        return
    columns, rows = np.rint(path.pixels).astype(int).T
    off = ~prediction.ground[rows, columns]
    taken_m = place_m(*np.nonzero(probability == 0)[::-1])
    away_m = np.linalg.norm(
        path.places_m[off][:, None] - place_m(*np.nonzero(probability)[::-1]), axis=-1
    )
    assert len(taken_m) and (not off.any() or away_m.min(axis=1).max() < 0.06)


def test_the_cheaper_way_goes_round_doubtful_ground():
    probability = np.ones(SIZE)
    probability[50:80, 30:] = 0.6
    path = world(probability).plan((100, 92), (100, 40))
    x, y = path.pixels.T
    assert ((y > 52) & (y < 78) & (x > 33)).sum() == 0
    straight_m = np.linalg.norm(place_m(100, 92) - place_m(100, 40))
    assert straight_m < path.length_m
    assert path.cost < 0.4 * straight_m


def test_metres_and_pixels_name_the_same_ends():
    prediction = world(np.ones(SIZE))
    path = prediction.plan(place_m(30, 90), place_m(100, 50), unit="m")
    same = prediction.plan((30, 90), (100, 50))
    np.testing.assert_allclose(path.pixels, same.pixels, atol=1e-3)


def test_pixels_are_those_of_the_picture_not_of_the_maps():
    path = world(np.ones(SIZE), times=3).plan((31, 271), (301, 151))
    np.testing.assert_allclose(path.pixels[[0, -1]], [[31, 271], [301, 151]], atol=1e-3)


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
    assert np.linalg.norm(between, axis=-1).min() >= margin_m - 0.01
    assert path.length_m > prediction.plan(start, goal).length_m


def table(called_ground):
    """A table top 0.6 m high that hides the floor; `called_ground` where a network is fooled."""
    prediction = world(np.ones(SIZE))
    visible, depth_m = np.ones(SIZE, np.float32), prediction.visible_depth_m.copy()
    visible[35:50, 40:90] = float(called_ground)
    depth_m[35:50, 40:90] *= (HEIGHT_M - 0.6) / HEIGHT_M
    return prediction.with_maps(visible_ground_probability=visible, visible_depth_m=depth_m)


@pytest.mark.parametrize("called_ground", [False, True])
def test_a_path_passes_no_table_top(called_ground):
    prediction = table(called_ground)
    grid = prediction.top_down()
    path = prediction.plan((64, 92), (64, 27))
    row = np.floor(len(grid.cells) - path.places_m[:, 0] / grid.cell_m).astype(int)
    column = np.floor(grid.cells.shape[1] / 2 - path.places_m[:, 1] / grid.cell_m).astype(int)
    assert (grid.cells == OCCUPIED).any()
    assert not (grid.cells[row, column] == OCCUPIED).any()


def test_a_path_never_ends_on_a_table_top():
    with pytest.raises(OffGroundError, match="table top"):
        table(called_ground=True).plan((64, 92), (64, 42))


def test_a_gap_narrower_than_twice_the_margin_is_closed():
    probability = np.ones(SIZE)
    probability[58:60] = 0
    probability[58:60, 52:76] = 1  # at this depth a pixel is about 2 cm wide: 0.5 m
    prediction = world(probability)
    gap_m = np.linalg.norm(place_m(75.5, 59) - place_m(51.5, 59))
    assert prediction.plan((20, 90), (20, 40), margin_m=0.3 * gap_m).length_m > 0
    with pytest.raises(NoPathError, match="margin"):
        prediction.plan((20, 90), (20, 40), margin_m=0.55 * gap_m)


def test_hidden_ground_is_reported_and_can_be_avoided():
    visible = np.ones(SIZE)
    visible[60:70, :100] = 0
    prediction = world(np.ones(SIZE), visible)
    behind = prediction.plan((20, 90), (20, 40))
    assert behind.passes_hidden_ground
    y = behind.pixels[:, 1]
    assert behind.hidden[(y > 61) & (y < 68)].all()
    assert not behind.hidden[(y < 57) | (y > 72)].any()
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
    with np.errstate(over="raise"), pytest.raises(OutsideError, match="outside the picture"):
        prediction.plan((1e308, -1e308), (2, 0), unit="m")


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
    monkeypatch.setitem(sys.modules, "scipy.sparse.csgraph", None)
    with pytest.raises(PlanningError, match=r"footprints-edge\[plan\]"):
        planning.require_graph_search()
    with pytest.raises(PlanningError, match="scipy"):
        world(np.ones(SIZE)).plan((20, 90), (30, 80))
