import io
import json
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from predictions import make_prediction

from footprints_edge.drawing.occupancy_grid import draw_bev
from footprints_edge.errors import GroundPlaneError, OutputError
from footprints_edge.geometry.camera import Intrinsics, rays
from footprints_edge.geometry.camera_pose import up_vector
from footprints_edge.geometry.ground_plane import GroundPlane, fit_ground_plane
from footprints_edge.navigation.obstacles import _bearings_in_view
from footprints_edge.navigation.occupancy_grid import (
    HIDDEN,
    MAX_CELLS,
    OCCUPIED,
    UNKNOWN,
    VISIBLE,
    OccupancyGrid,
)
from footprints_edge.outputs.json_summary import summarise

SIZE = (256, 448)
CAMERA = Intrinsics(300, 300, 223.5, 127.5)
HEIGHT_M, PITCH = 1.5, np.radians(20)
BOX = (3.0, 3.8, -0.5, 0.6, 0.7)
"""Nearest and farthest x, lowest and highest y of its footprint, its height, metres."""


def exact():
    """A floor with a box on it, seen by exact ray casting in ground coordinates."""
    across = (np.arange(SIZE[1]) - CAMERA.cx)[None, :] / CAMERA.fx + np.zeros(SIZE)
    along = (np.arange(SIZE[0]) - CAMERA.cy)[:, None] / CAMERA.fy + np.zeros(SIZE)
    forward = np.cos(PITCH) - np.sin(PITCH) * along
    rise = -np.sin(PITCH) - np.cos(PITCH) * along
    floor_m = np.where(rise < -1e-3, HEIGHT_M / -np.minimum(rise, -1e-3), 1e3)
    ray = np.stack([forward, -across, rise], axis=-1)
    low = np.array([BOX[0], BOX[2], 0.0])
    high = np.array([BOX[1], BOX[3], BOX[4]])
    camera = np.array([0, 0, HEIGHT_M])
    with np.errstate(divide="ignore", invalid="ignore"):
        slabs = np.sort(np.stack([(low - camera) / ray, (high - camera) / ray]), axis=0)
    enter, leave = slabs[0].max(axis=-1), slabs[1].min(axis=-1)
    box_m = np.where((enter < leave) & (enter > 0), enter, np.inf)
    x, y = forward * floor_m, -across * floor_m
    footprint = (x > BOX[0]) & (x < BOX[1]) & (y > BOX[2]) & (y < BOX[3])
    ground = (rise < -1e-3) & ~footprint
    visible = ground & (floor_m < box_m)
    return make_prediction(
        floor_m,
        ground=ground,
        visible_ground=visible,
        visible_depth_m=np.minimum(box_m, floor_m),
        intrinsics=CAMERA,
        name="room.jpg",
    )


@pytest.fixture(scope="module")
def scene():
    return exact()


@pytest.fixture(scope="module")
def grid(scene):
    return scene.top_down(cell_m=0.05, range_m=6)


@pytest.fixture(scope="module")
def walkable(scene):
    return scene.walkable_behind_things(cell_m=0.05, range_m=6)


def centres(grid):
    rows, columns = grid.cells.shape
    r, c = np.mgrid[:rows, :columns]
    return (rows - r - 0.5) * grid.cell_m, (columns / 2 - c - 0.5) * grid.cell_m


def test_walkable_cells_are_those_of_the_floor_plan(walkable):
    x, y = centres(walkable)
    depth = x * np.cos(PITCH) + HEIGHT_M * np.sin(PITCH)
    u = CAMERA.cx - CAMERA.fx * y / depth
    v = CAMERA.cy + CAMERA.fy * (HEIGHT_M * np.cos(PITCH) - x * np.sin(PITCH)) / depth
    in_view = (u >= 0) & (u < 447) & (v >= 0) & (v < 255) & (np.hypot(x, y) < 6)
    box = (x > BOX[0]) & (x < BOX[1]) & (y > BOX[2]) & (y < BOX[3])
    expected = in_view & ~box
    overlap = (walkable.walkable & expected).sum() / (walkable.walkable | expected).sum()
    assert overlap > 0.97
    assert (walkable.cells[box] == OCCUPIED).mean() > 0.85
    area_m2 = walkable.free_area_m2 + walkable.hidden_area_m2
    assert area_m2 == pytest.approx(expected.sum() * 0.05**2, rel=0.03)


def test_the_box_is_occupied_and_the_floor_behind_it_is_not_free(grid, walkable):
    x, y = centres(grid)
    box = (x > BOX[0]) & (x < BOX[1]) & (y > BOX[2]) & (y < BOX[3])
    assert (grid.cells[box] == OCCUPIED).mean() > 0.8
    rim = (x > BOX[0] - 0.1) & (x < BOX[1] + 0.25) & (y > BOX[2] - 0.15) & (y < BOX[3] + 0.15)
    assert not (grid.cells == OCCUPIED)[~rim].any()
    shadow = (walkable.cells == HIDDEN) & ~rim
    assert shadow.sum() > 200
    assert (grid.cells[shadow] == HIDDEN).all()
    assert not grid.free[shadow].any()


@pytest.mark.parametrize(("robot_height_m", "stands"), [(0.5, True), (1.0, False), (1.6, True)])
def test_a_robot_passes_beneath_what_is_higher(robot_height_m, stands):
    """A lamp or a shelf: seen from 0.9 to 1.4 m above the floor and, for 0.5, a box of 0.7 m."""
    scene = exact() if robot_height_m == 0.5 else with_a_shelf()
    cells = scene.top_down(0.05, 6, robot_height_m=robot_height_m).cells
    assert (cells == OCCUPIED).any() == stands


def with_a_shelf():
    """Nothing but a board, 1.2 m above the floor."""
    scene = exact()
    rows = slice(60, 80)
    down = np.cos(PITCH) * (np.arange(SIZE[0]) - CAMERA.cy) / CAMERA.fy + np.sin(PITCH)
    lifted = scene.unmasked_ground_depth_m.copy()
    lifted[rows, 200:250] = ((HEIGHT_M - 1.2) / down[rows])[:, None]
    visible = scene.ground.astype(np.float32)
    visible[rows, 200:250] = 0
    return scene.with_maps(
        visible_ground_probability=visible,
        ground_probability=np.ones(SIZE, np.float32),
        visible_depth_m=lifted,
    )


@pytest.mark.parametrize(("robot_height_m", "stands"), [(1.0, False), (1.6, True)])
def test_the_height_given_to_predict_holds_for_all_results(robot_height_m, stands):
    scene = replace(with_a_shelf(), robot_height_m=robot_height_m)
    assert (scene.top_down(0.05, 6).cells == OCCUPIED).any() == stands
    assert np.isfinite(scene.scan().ranges_m).any() == stands
    assert (summarise(scene)["nearest_obstacle_m"] is not None) == stands
    black = np.asarray(draw_bev(scene, 300)) == (8, 9, 13)
    assert black.all(axis=-1).any() == stands
    if stands:
        facts = summarise(scene)
        at_m = scene.scan([facts["nearest_obstacle_bearing_deg"]]).ranges_m[0]
        assert facts["nearest_obstacle_m"] == pytest.approx(at_m, abs=1e-3)
        assert facts["robot_height_m"] == robot_height_m


def test_noise_of_a_few_pixels_is_no_obstacle(scene):
    rng = np.random.default_rng(0)
    floor_m = scene.unmasked_ground_depth_m
    noisy = floor_m * np.exp(rng.normal(0, 0.03, SIZE)).astype(np.float32)
    speckled = scene.with_maps(
        visible_ground_probability=np.where(rng.random(SIZE) < 1e-3, 0, 1).astype(np.float32),
        ground_probability=np.ones(SIZE, np.float32),
        visible_depth_m=np.where(rng.random(SIZE) < 1e-3, floor_m / 2, noisy),
    )
    assert not (speckled.top_down(0.05, 6).cells == OCCUPIED).any()


def test_an_obstacle_begins_at_the_nearest_of_what_is_seen_of_it(scene):
    """A thing that leans away, so near that one row of its pixels in a bin is not enough."""
    nearest_m, rows = 1.5, np.arange(214, 208, -1)
    columns = np.arange(200, 248)
    forward = np.cos(PITCH) - np.sin(PITCH) * (rows - CAMERA.cy) / CAMERA.fy
    depth_m = scene.unmasked_ground_depth_m.copy()
    depth_m[np.ix_(rows, columns)] = (nearest_m * 1.02 ** (3 * np.arange(6)) / forward)[:, None]
    visible = np.ones(SIZE, np.float32)
    visible[np.ix_(rows, columns)] = 0
    leaning = scene.with_maps(
        visible_ground_probability=visible,
        ground_probability=np.ones(SIZE, np.float32),
        visible_depth_m=depth_m,
    )
    np.testing.assert_allclose(leaning.scan([0.0]).ranges_m, [nearest_m], rtol=0.02)


def test_the_depths_scale_comes_from_the_visible_ground(scene):
    off = scene.with_maps(visible_depth_m=scene.visible_depth_m * np.float32(1.3))
    np.testing.assert_allclose(off.scan([0.0]).ranges_m, [3.0], atol=0.1)


def test_a_scan_says_where_nothing_is_and_what_is_not_in_view(scene, grid):
    scan = scene.scan()
    assert scan.bearings_deg.shape == scan.ranges_m.shape == scan.confidence.shape == (181,)
    at = dict(zip(scan.bearings_deg, scan.ranges_m, strict=True))
    np.testing.assert_allclose(at[0.0], 3.0, atol=0.08)
    assert np.isinf(at[25.0])
    assert np.isnan(at[60.0])
    finite = np.isfinite(scan.ranges_m)
    assert ((scan.confidence > 0) == finite).all()
    assert scan.confidence.max() <= 1
    near_m = grid.nearest_obstacle_m(scan.bearings_deg[finite])
    np.testing.assert_allclose(near_m, scan.ranges_m[finite], atol=0.16)


def test_a_robot_lower_than_a_step_is_refused(scene):
    with pytest.raises(ValueError, match=r"robot_height_m is 0\.1"):
        scene.top_down(robot_height_m=0.1)
    with pytest.raises(ValueError, match="robot_height_m is nan"):
        scene.scan(robot_height_m=float("nan"))


def test_hidden_cells_lie_in_the_shadow_of_the_box(grid):
    x, _ = centres(grid)
    hidden = grid.cells == HIDDEN
    assert grid.hidden_area_m2 == pytest.approx(hidden.sum() * 0.05**2)
    # the top edge at the back throws the farthest shadow: similar triangles
    reach_m = BOX[1] * HEIGHT_M / (HEIGHT_M - BOX[4])
    assert hidden.any()
    assert x[hidden].min() > BOX[0]
    assert min(6, reach_m) - 0.6 < x[hidden].max() < reach_m + 0.1


def test_the_last_row_is_below_the_camera_and_left_is_left(grid):
    assert grid.cells.shape == (120, 240)
    assert (grid.cells[-1] == UNKNOWN).all()  # below the picture's lower border
    narrow = grid.cells == OCCUPIED
    columns = np.flatnonzero(narrow.any(axis=0))
    np.testing.assert_allclose((120 - columns[[0, -1]] - 0.5) * 0.05, [0.6, -0.5], atol=0.08)


def test_the_nearest_obstacle_by_bearing(grid):
    bearings_deg = np.array([0.0, 5.0, -5.0, 25.0])
    expected_m = [3.0, 3.0 / np.cos(np.radians(5)), 3.0 / np.cos(np.radians(5)), np.inf]
    np.testing.assert_allclose(grid.nearest_obstacle_m(bearings_deg), expected_m, atol=0.08)


@pytest.mark.filterwarnings("error")
def test_bearings_that_are_none_have_no_distance(grid):
    np.testing.assert_array_equal(grid.nearest_obstacle_m([np.nan, np.inf]), [np.nan, np.nan])


def test_one_bearing_is_enough(scene, grid):
    np.testing.assert_allclose(grid.nearest_obstacle_m(0.0), [3.0], atol=0.08)
    np.testing.assert_allclose(scene.scan(0.0).ranges_m, [3.0], atol=0.08)


@pytest.mark.parametrize(
    ("cell_m", "range_m", "rows"), [(0.3, 1.0, 4), (0.3, 6.1, 21), (0.1, 1.1, 11), (0.1, 0.3, 3)]
)
def test_a_grid_reaches_as_far_as_its_range(scene, cell_m, range_m, rows):
    assert scene.top_down(cell_m, range_m).cells.shape == (rows, 2 * rows)
    assert scene.walkable_behind_things(cell_m, range_m).cells.shape == (rows, 2 * rows)


def test_places_follow_from_both_sides(grid):
    x, y = centres(grid)
    np.testing.assert_allclose(grid.places_m, np.dstack([x, y]), atol=1e-9)
    cut = OccupancyGrid(grid.cells[:, 80:140], grid.cell_m, grid.plane)
    np.testing.assert_allclose(cut.places_m, np.dstack(centres(cut)), atol=1e-9)


def test_bands_of_a_large_grid_fit_together(scene, monkeypatch):
    whole, walkable = scene.top_down(0.05, 6), scene.walkable_behind_things(0.05, 6)
    monkeypatch.setattr("footprints_edge.navigation.occupancy_grid._BAND_CELLS", 2000)
    np.testing.assert_array_equal(scene.top_down(0.05, 6).cells, whole.cells)
    np.testing.assert_array_equal(scene.walkable_behind_things(0.05, 6).cells, walkable.cells)


def test_the_largest_grid_takes_little_memory(scene):
    scene.top_down()  # what is computed once
    tracemalloc.start()
    grid = scene.top_down(0.008, 0.008 * MAX_CELLS)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert grid.cells.size == 2 * MAX_CELLS**2
    assert peak < 100e6  # beside some 100 MB of the process with its model


def test_cells_far_behind_the_visible_surface_are_unknown(scene):
    """A wall 2 m ahead: no ground from there on; its first metre counts as the obstacle."""
    wall_m = np.float32(2.0)
    pixels = np.stack(np.meshgrid(np.arange(SIZE[1]), np.arange(SIZE[0])), axis=-1)
    forward = scene.ground_plane().at_pixels(pixels, CAMERA)[..., 0]
    beyond = ~(forward < wall_m)
    along = (np.arange(SIZE[0]) - CAMERA.cy)[:, None] / CAMERA.fy + np.zeros(SIZE)
    to_wall_m = (wall_m / (np.cos(PITCH) - np.sin(PITCH) * along)).astype(np.float32)
    walled = scene.with_maps(
        visible_ground_probability=(~beyond).astype(np.float32),
        ground_probability=(~beyond).astype(np.float32),
        visible_depth_m=np.where(beyond, to_wall_m, scene.unmasked_ground_depth_m),
    )
    column = walled.walkable_behind_things(0.05, 6).cells[::-1, 120]  # straight ahead, near to far
    assert column[int(1.9 / 0.05)] == VISIBLE
    assert column[int(2.2 / 0.05)] == OCCUPIED
    assert column[int(3.2 / 0.05)] == UNKNOWN
    column = walled.top_down(0.05, 6).cells[::-1, 120]
    assert column[int(1.9 / 0.05)] == VISIBLE
    assert OCCUPIED in column[int(1.9 / 0.05) : int(2.2 / 0.05)]
    assert (column[int(2.3 / 0.05) :] == UNKNOWN).all()


def read_yaml(text):
    """The flat YAML of a map, read without a YAML library: each value here is also JSON."""
    pairs = (line.split(": ", 1) for line in text.splitlines())
    return {key: value if key == "mode" else json.loads(value) for key, value in pairs}


@pytest.mark.parametrize("hidden", ["cost", "unknown", "free"])
def test_a_map_server_finds_every_cell_where_it_is(grid, tmp_path, hidden):
    yaml, png = grid.save(tmp_path / "map.yaml", hidden)
    facts = read_yaml(yaml.read_text())
    assert facts["image"] == png.name
    with Image.open(tmp_path / facts["image"]) as image:
        assert image.mode == ("LA" if hidden == "cost" else "L")
        grey, alpha = (np.asarray(band) for band in image.convert("LA").split())
    # map_server: occupancy is (255 - grey) / 255, the origin is the lower left pixel's corner
    occupancy = (255 - grey[::-1].astype(float)) / 255
    x, y = centres(grid)
    column = np.floor((x - facts["origin"][0]) / facts["resolution"]).astype(int)
    row = np.floor((y - facts["origin"][1]) / facts["resolution"]).astype(int)
    read, alpha = occupancy[row, column], alpha[::-1][row, column]
    occupied, free = read > facts["occupied_thresh"], read < facts["free_thresh"]
    np.testing.assert_array_equal(occupied, grid.cells == OCCUPIED)
    np.testing.assert_array_equal(free, grid.walkable if hidden == "free" else grid.free)
    assert facts["mode"] == ("scale" if hidden == "cost" else "trinary")
    if hidden == "cost":
        np.testing.assert_array_equal(alpha == 0, grid.cells == UNKNOWN)
        low, high = facts["free_thresh"], facts["occupied_thresh"]
        cost = 100 * (read - low) / (high - low)
        np.testing.assert_allclose(cost[grid.cells == HIDDEN], 50, atol=1)


@pytest.mark.parametrize("name", ["map.png", "map", "map.yaml.bak"])
def test_a_map_is_named_as_yaml(grid, tmp_path, name):
    with pytest.raises(OutputError, match=r"give map\.yaml"):
        grid.save(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("there", ["map.yaml", "map.png"])
def test_a_map_replaces_files_only_on_request(grid, tmp_path, there):
    (tmp_path / there).write_text("mine")
    with pytest.raises(OutputError, match=there):
        grid.save(tmp_path / "map.yaml")
    assert [path.read_text() for path in tmp_path.iterdir()] == ["mine"]
    grid.save(tmp_path / "map.yaml", overwrite=True)
    assert read_yaml((tmp_path / "map.yaml").read_text())["image"] == "map.png"
    assert (tmp_path / "map.png").read_bytes() == grid.map_png()


def test_another_word_for_hidden_ground_is_refused(grid, tmp_path):
    with pytest.raises(ValueError, match="hidden is 'grey'"):
        grid.save(tmp_path / "map.yaml", "grey")
    assert list(tmp_path.iterdir()) == []


def test_the_format_names_the_picture_beside_it(scene, tmp_path):
    png, yaml = scene.save(tmp_path, ["topdown"], name="a b.jpg")
    assert (png.name, yaml.name) == ("a b.jpg.topdown.png", "a b.jpg.topdown.yaml")
    assert read_yaml(yaml.read_text())["image"] == png.name
    with Image.open(io.BytesIO(png.read_bytes())) as image:
        assert image.size == (200, 400)


def test_invalid_grids_are_refused(scene, tmp_path):
    with pytest.raises(ValueError, match="cell_m is 0"):
        scene.top_down(cell_m=0)
    with pytest.raises(ValueError, match=r"range_m is 1e\+308"):
        scene.top_down(1e308, 1e308)
    with pytest.raises(ValueError, match="range_m is nan"):
        scene.top_down(range_m=float("nan"))
    none = scene.with_maps(ground_probability=np.zeros(SIZE, np.float32))
    with pytest.raises(GroundPlaneError, match="shows no ground"):
        none.top_down()
    plane = fit_ground_plane(scene.unmasked_ground_depth_m, scene.ground, CAMERA)
    with pytest.raises(OutputError, match="cannot write"):
        (tmp_path / "no").touch()
        OccupancyGrid(np.zeros((4, 8), np.uint8), 0.05, plane).save(tmp_path / "no" / "map.yaml")
    with pytest.raises(OutputError, match="null"):
        OccupancyGrid(np.zeros((4, 8), np.uint8), 0.05, plane).save("a\0.yaml")


def test_where_walkable_ground_ends_in_view_something_is_occupied(walkable):
    grid = walkable
    free = np.pad(grid.walkable, 1)
    shifted = [free[i : i + 120, j : j + 240] for i in range(3) for j in range(3)]
    x, y = centres(grid)
    inner = (x > BOX[0]) & (x < BOX[1]) & (y > BOX[2]) & (y < BOX[3])
    rim = np.any(shifted, axis=0) & ~grid.walkable & inner
    assert rim.sum() > 50
    assert (grid.cells[rim] == OCCUPIED).all()


@pytest.mark.parametrize("lean_deg", [0, 25, -60])
@pytest.mark.parametrize("pitch_deg", [-20, 5, 40, 75, 90])
@pytest.mark.parametrize("focal_px", [25, 110])
def test_a_bearing_is_in_view_where_the_ray_of_some_pixel_has_it(pitch_deg, lean_deg, focal_px):
    camera = Intrinsics(focal_px, focal_px, 63.5, 47.5)
    plane = GroundPlane(up_vector(pitch_deg, lean_deg), 1.5, 0.0)
    forward, left, _ = np.moveaxis(rays(camera, (96, 128)) @ plane.axes.T, -1, 0)
    expected = set(np.rint(np.degrees(np.arctan2(left, forward))).astype(int).ravel())
    across = ((np.arange(128) - 63.5) / focal_px).astype(np.float32)
    along = ((np.arange(96) - 47.5) / focal_px).astype(np.float32)
    found = _bearings_in_view(plane.axes.astype(np.float32), across, along)
    differ = set(np.flatnonzero(found) - 90) ^ {each for each in expected if abs(each) <= 90}
    assert len(differ) <= 2  # angles that just reach a half
