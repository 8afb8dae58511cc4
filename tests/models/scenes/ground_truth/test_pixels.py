"""The exact answer: closed forms for floors and boxes, the rules of what is walkable, and what
holds in every made scene."""

import numpy as np
import pytest

from footprints_edge_models.scenes.assets.furniture import tables
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.things import Patch, box, joined, rectangle
from footprints_edge_models.scenes.assets.vehicles import cars
from footprints_edge_models.scenes.generate import generate_scene
from footprints_edge_models.scenes.ground_truth.pixels import (
    BEHIND_WALL,
    FOOTPRINT,
    GROUND_ANYWHERE,
    VISIBLE_GROUND,
)


def world_rays(camera):
    _, directions = camera.rays()
    return directions.reshape(*camera.size, 3).astype(np.float64)


def floor_points(camera, height_m=0.0):
    """Depth to the plane z = height_m and the x, y where it is met, in closed form."""
    rays = world_rays(camera)
    with np.errstate(divide="ignore"):
        depth = (height_m - camera.position_m[2]) / rays[..., 2]
    return depth, camera.position_m[:2] + rays[..., :2] * depth[..., None]


def test_an_empty_floor_is_seen_at_its_plane_depth(scene_of, camera, truth_for):
    truth = truth_for(scene_of(), camera)
    depth, at = floor_points(camera)
    on_floor = (depth > 0) & (np.abs(at) < 10).all(axis=-1)
    inner = (depth > 0) & (np.abs(at) < 9.9).all(axis=-1)
    assert inner.sum() > 1000
    assert (truth.bits[inner] == VISIBLE_GROUND | GROUND_ANYWHERE).all()
    assert np.allclose(truth.ground_depth_m[inner], depth[inner], rtol=1e-4)
    assert np.array_equal(truth.visible_depth_m, truth.ground_depth_m)
    assert (truth.bits[~on_floor & ~((np.abs(at) < 10.1).all(axis=-1) & (depth > 0))] == 0).all()


def test_a_box_hides_the_floor_and_takes_its_outline(scene_of, camera, truth_for, plain):
    crate = joined("box", [box(plain, (1.0, 0.8, 0.6), (0, 0, 0))]).at(0.3, 4.0)
    truth = truth_for(scene_of(crate), camera)
    depth, at = floor_points(camera)
    x, y = at[..., 0], at[..., 1]
    margin = 0.02
    inside = (depth > 0) & (np.abs(x - 0.3) < 0.5 - margin) & (np.abs(y - 4.0) < 0.4 - margin)
    outside = (depth > 0) & (np.abs(at) < 9.9).all(axis=-1)
    outside &= (np.abs(x - 0.3) > 0.5 + margin) | (np.abs(y - 4.0) > 0.4 + margin)
    assert inside.sum() > 20
    assert (truth.bits[inside] == FOOTPRINT).all()
    assert (truth.bits[outside] & GROUND_ANYWHERE > 0).all()
    hidden = truth.bits == GROUND_ANYWHERE
    assert hidden.sum() > 20
    # what hides is nearer than what is hidden, and what is hidden is where the plane says
    assert (truth.visible_depth_m[hidden] < truth.ground_depth_m[hidden]).all()
    assert np.allclose(truth.ground_depth_m[hidden], depth[hidden], rtol=1e-4)
    # the front of the box stands at y = 3.6: along each ray, that is where it is seen
    rays = world_rays(camera)
    front = (truth.bits & VISIBLE_GROUND == 0) & (truth.visible_depth_m > 0)
    met_y = rays[..., 1] * truth.visible_depth_m
    met_z = 1.5 + rays[..., 2] * truth.visible_depth_m
    face = front & (met_z < 0.59)
    assert face.sum() > 20
    assert np.allclose(met_y[face], 3.6, atol=1e-3)


def test_ground_under_a_table_is_ground_and_under_a_low_box_is_not(
    scene_of, camera, truth_for, plain
):
    for height_m, walkable in ((0.7, True), (0.2, False)):
        top = joined("table", [box(plain, (1.5, 1.5, 0.05), (0, 0, height_m))]).at(0, 4.0)
        truth = truth_for(scene_of(top), camera)
        depth, at = floor_points(camera)
        below = (depth > 0) & (np.abs(at - (0, 4.0)) < 0.7).all(axis=-1)
        assert (truth.bits[below] & GROUND_ANYWHERE > 0).all() == walkable
        assert (truth.bits[below] & FOOTPRINT > 0).all() != walkable


def test_a_table_top_is_never_visible_ground(scene_of, camera, truth_for, library):
    palette = Palette(library, np.random.default_rng(1))
    table = tables.table(palette, 1.6, 0.9, 0.74, laid=0.0).at(0, 2.5)
    truth = truth_for(scene_of(table), camera)
    height = 1.5 + world_rays(camera)[..., 2] * truth.visible_depth_m
    on_top = (np.abs(height - 0.74) < 0.01) & (truth.visible_depth_m > 0)
    assert on_top.sum() > 50
    assert (truth.bits[on_top] & VISIBLE_GROUND == 0).all()
    assert (truth.bits[on_top] & GROUND_ANYWHERE > 0).mean() > 0.9


def test_the_ground_under_a_vehicle_is_not_walkable(scene_of, camera, truth_for, library):
    for seed in range(3):
        car = cars.car(Palette(library, np.random.default_rng(seed)))
        low, high = car.extent
        truth = truth_for(scene_of(car.at(0, 5.0)), camera)
        depth, at = floor_points(camera)
        shrunk = np.minimum(-low[:2], high[:2]) - 0.35
        below = (depth > 0) & (np.abs(at - (0, 5.0)) < shrunk).all(axis=-1)
        assert below.any()
        assert (truth.bits[below] & (GROUND_ANYWHERE | VISIBLE_GROUND) == 0).all()


def test_a_kerb_is_walked_on_at_its_own_height(scene_of, camera, truth_for, plain):
    road = Patch(rectangle(-10, -10, 10, 4), 0.0, plain)
    pavement = Patch(rectangle(-10, 4, 10, 10), 0.15, plain)
    truth = truth_for(scene_of(ground=(road, pavement)), camera)
    depth, at = floor_points(camera, 0.15)
    behind = (depth > 0) & (at[..., 1] > 4.02) & (np.abs(at) < 9.9).all(axis=-1)
    assert behind.sum() > 100
    assert (truth.bits[behind] == VISIBLE_GROUND | GROUND_ANYWHERE).all()
    assert np.allclose(truth.ground_depth_m[behind], depth[behind], rtol=1e-4)


def test_a_slope_tilts_everything(scene_of, camera, truth_for):
    truth = truth_for(scene_of(slope=(0.02, 0.05)), camera)
    rays = world_rays(camera)
    normal = np.array([-0.02, -0.05, 1.0])
    depth = -(normal @ camera.position_m) / (rays @ normal)
    seen = truth.bits & VISIBLE_GROUND > 0
    assert seen.sum() > 1000
    assert np.allclose(truth.ground_depth_m[seen], depth[seen], rtol=1e-4)


def test_floor_behind_a_wall_is_ground_and_marked(scene_of, camera, truth_for, plain):
    wall = joined("wall", [box(plain, (20, 0.2, 3), (0, 0, 0))], is_wall=True).at(0, 5.0)
    truth = truth_for(scene_of(wall), camera)
    depth, at = floor_points(camera)
    beyond = (depth > 0) & (at[..., 1] > 5.2) & (np.abs(at) < 9.9).all(axis=-1)
    assert (truth.bits[beyond] == GROUND_ANYWHERE | BEHIND_WALL).all()
    before = (depth > 0) & (at[..., 1] < 4.8)
    assert (truth.bits[before] & BEHIND_WALL == 0).all()


@pytest.mark.parametrize("number", range(12))
def test_what_holds_in_every_scene(library, number):
    made = generate_scene(library, 7, number, (96, 160))
    truth = made.ground_truth
    seen, ground = truth.bits & VISIBLE_GROUND > 0, truth.bits & GROUND_ANYWHERE > 0
    taken = truth.bits & FOOTPRINT > 0
    assert made.image.shape == (*truth.bits.shape, 3)
    assert made.image.std() > 3
    assert not (seen & ~ground).any()
    assert not (ground & taken).any()
    assert np.array_equal(truth.visible_depth_m[seen], truth.ground_depth_m[seen])
    assert ((truth.ground_depth_m > 0) == (ground | taken)).all()
    hidden = ground & ~seen
    assert (truth.visible_depth_m[hidden] > 0).all()
    assert (truth.ground_depth_m[hidden] >= truth.visible_depth_m[hidden] - 1e-3).all()
    assert not (truth.bits[seen] & BEHIND_WALL).any()
    focal_px = made.camera.intrinsics.focal_px
    hfov = np.degrees(2 * np.arctan(truth.bits.shape[1] / 2 / focal_px))
    assert 38 < hfov <= 95.1
