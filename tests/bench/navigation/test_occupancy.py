"""Occupancy grids of synthetic scenes: exact maps against the exact floor plan."""

from dataclasses import dataclass

import numpy as np
import pytest

pytest.importorskip("embreex", reason="scenes are made by ray casting")

from footprints_edge.geometry.ground_plane import GroundPlane
from footprints_edge_bench.ground_truth.base import GroundTruth, LabelledMask
from footprints_edge_bench.navigation.occupancy import (
    CELL_M,
    RANGE_M,
    compare_grids,
    exact_prediction,
    valid_cells,
)
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.ground_truth.pixels import (
    GROUND_ANYWHERE,
    VISIBLE_GROUND,
    SceneGroundTruth,
    trace_ground_truth,
)
from footprints_edge_models.scenes.layout.rooms.interior import draw_rooms
from footprints_edge_models.scenes.rendering.cameras import Camera, choose_camera
from footprints_edge_models.scenes.rendering.geometry import GROUND, Geometry, geometry_of
from footprints_edge_models.scenes.rendering.raycast import Triangles

SIZE = (256, 448)


@dataclass(frozen=True)
class Room:
    geometry: Geometry
    camera: Camera
    truth: SceneGroundTruth


def judged(made):
    """Its ground truth as the benchmark has it."""
    everywhere = np.ones(made.camera.size, bool)
    return GroundTruth(
        None,
        made.camera.size,
        made.camera.intrinsics,
        LabelledMask(made.truth.bits & VISIBLE_GROUND > 0, everywhere),
        LabelledMask(made.truth.bits & GROUND_ANYWHERE > 0, everywhere),
        made.truth.visible_depth_m,
        made.truth.ground_depth_m,
    )


class Like:
    """Stands in for a prediction: only its camera is asked for."""

    def __init__(self, made):
        self.intrinsics, self.map_size = made.camera.intrinsics, made.camera.size


def floor_plan(made, grid):
    """Free cells in view by the geometry of the scene alone: nothing goes through its maps."""
    up = made.camera.rotation.T @ np.array([0.0, 0.0, 1.0])
    plane = GroundPlane(up, made.camera.position_m[2], 0.0)
    places_m = grid.places_m.reshape(-1, 2)
    below = np.column_stack([places_m, np.full(len(places_m), -plane.camera_height_m)])
    points = below @ plane.axes @ made.camera.rotation.T + made.camera.position_m
    np.testing.assert_allclose(points[:, 2], 0, atol=1e-6)
    lift, drop = points.astype(np.float32), points.astype(np.float32)
    lift[:, 2], drop[:, 2] = -1, 0.02
    rise = np.tile(np.float32([0, 0, 1]), (len(points), 1))
    taken = Triangles(made.geometry.outlines).first_hits(lift, rise).triangle >= 0
    ground = Triangles(made.geometry.corners[made.geometry.thing == GROUND])
    there = ground.first_hits(drop, -rise)
    free = (there.triangle >= 0) & ~taken
    x, y = plane.to_pixels(places_m, made.camera.intrinsics).T
    height, width = made.camera.size
    with np.errstate(invalid="ignore"):
        in_view = (x >= -0.5) & (x < width - 0.5) & (y >= -0.5) & (y < height - 0.5)
    in_view &= np.hypot(*places_m.T) <= RANGE_M
    return (free & in_view).reshape(grid.cells.shape)


@pytest.fixture(scope="module")
def rooms():
    """Level rooms with their cameras and ground truth; nobody renders a picture."""
    made = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        scene = draw_rooms(Palette(TextureLibrary("test"), rng))
        geometry = geometry_of(scene)
        solids, outlines = Triangles(geometry.corners), Triangles(geometry.outlines)
        camera = choose_camera(scene, geometry, SIZE, rng, solids, outlines)
        made.append(Room(geometry, camera, trace_ground_truth(camera, geometry, solids, outlines)))
    return made


def test_walkable_cells_of_exact_maps_are_those_of_the_floor_plan(rooms):
    overlaps = []
    for made in rooms:
        grid = exact_prediction(judged(made), Like(made)).walkable_behind_things(CELL_M, RANGE_M)
        plan = floor_plan(made, grid)
        assert plan.sum() * CELL_M**2 > 0.5
        overlaps.append((grid.walkable & plan).sum() / (grid.walkable | plan).sum())
    assert min(overlaps) >= 0.8, overlaps
    assert np.mean(overlaps) >= 0.9, overlaps


def test_the_score_is_the_overlap_of_known_cells(rooms):
    made = rooms[0]
    ground_truth = judged(made)
    exact = exact_prediction(ground_truth, Like(made))
    grid = exact.walkable_behind_things(CELL_M, RANGE_M)
    valid = valid_cells(grid, ground_truth, exact.intrinsics)
    assert valid.all()
    perfect = compare_grids(grid, grid, valid)
    assert (perfect.iou, perfect.area, perfect.height, perfect.pitch) == (1, 0, 0, 0)
    half = valid.copy()
    rows = np.flatnonzero(grid.walkable.any(axis=1))
    cells = grid.cells.copy()
    cells[rows[::2]] = 0
    part = type(grid)(cells, grid.cell_m, grid.plane)
    score = compare_grids(part, grid, half)
    assert score.iou == pytest.approx(part.walkable.sum() / grid.walkable.sum())
    assert score.area == pytest.approx(1 - score.iou)
    half[rows[::2]] = False  # where nobody knows, nothing is missing
    assert compare_grids(part, grid, half).iou == 1


def test_cells_on_rays_that_nobody_knows_do_not_count(rooms):
    made = rooms[0]
    ground_truth = judged(made)
    exact = exact_prediction(ground_truth, Like(made))
    grid = exact.walkable_behind_things(CELL_M, RANGE_M)
    valid = ground_truth.ground.valid.copy()
    valid[:, : made.camera.size[1] // 2] = False
    unknown = GroundTruth(
        None, ground_truth.size, ground=LabelledMask(ground_truth.ground.mask & valid, valid)
    )
    left_out = ~valid_cells(grid, unknown, exact.intrinsics)
    assert left_out.any()
    assert grid.places_m[left_out][:, 1].mean() > 0  # the picture's left is +y
