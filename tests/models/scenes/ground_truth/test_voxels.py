"""Voxels of surfaces that are no solids: as those of solids, large triangles and small ones."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from footprints_edge_models.scenes.assets.things import box, joined
from footprints_edge_models.scenes.ground_truth.voxels import CLASSES, VOXEL_M, voxels_of
from footprints_edge_models.scenes.layout.scene import Scene
from footprints_edge_models.scenes.rendering.geometry import geometry_of


@pytest.fixture
def labels_of(scene_of, camera):
    def labels(*things):
        scene = scene_of(*things)
        return voxels_of(scene, geometry_of(scene), camera).labels

    return labels


def surface(material, size, at):
    """A box as files hold things: its triangles, of which nobody knows what they enclose."""
    part = box(material, size, at)
    return replace(part, shape=replace(part.shape, convex=False))


def test_a_wall_of_two_triangles_fills_its_plane(labels_of, plain):
    thick_m = VOXEL_M / 2
    middle = 3 + VOXEL_M / 2  # of the voxels that it goes through
    wall = joined("wall", [surface(plain, (80, thick_m, 30), (0, middle, 0.001))], is_wall=True)
    filled = labels_of(wall) == CLASSES.index("wall")
    row = int(middle / VOXEL_M)
    assert filled[:, row, 5:].all()
    assert not filled[:, : row - 1].any()
    assert not filled[:, row + 2 :].any()


def test_a_slanting_surface_goes_through_the_voxels_that_points_on_it_are_in(labels_of, plain):
    part = surface(plain, (1.5, 0.9, 0.8), (0.0, 0.0, 0.03))
    sofa = joined("sofa", [part]).at(0.2, 2.5, yaw=0.5)
    filled = labels_of(sofa) == CLASSES.index("sofa")
    corners = geometry_of(Scene("street", (), (sofa,), (), None, (1, 1, 1), ())).corners
    mesh = trimesh.Trimesh(corners.reshape(-1, 3), np.arange(corners.size // 3).reshape(-1, 3))
    points = trimesh.sample.sample_surface(mesh, 60000, seed=0)[0]
    grid = np.floor((points + np.array([2.4, 0, 0.4])) / VOXEL_M).astype(int)
    cells, count = np.unique(grid, axis=0, return_counts=True)
    assert filled[tuple(cells[count > 20].T)].mean() > 0.97
    assert filled.sum() < 1.01 * len(cells)


def test_what_lies_flat_on_the_floor_is_floor(labels_of, plain):
    mat = joined("mat", [surface(plain, (2, 1, 0.01), (0, 2, 0))])
    assert np.array_equal(labels_of(mat), labels_of())


def test_a_thing_that_lost_its_parts_fills_nothing(labels_of, plain):
    gone = replace(joined("chair", [box(plain, (1, 1, 1), (0, 2, 0))]), parts=())
    assert np.array_equal(labels_of(gone), labels_of())
