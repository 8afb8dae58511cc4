"""Simplified models keep their shape, their size and the places of their texture."""

import numpy as np
import pytest
import trimesh

from footprints_edge_models.asset_files.asset import Surface
from footprints_edge_models.asset_files.simplify import simplified

pytest.importorskip("fast_simplification")
TEXTURE = np.zeros((8, 8, 3), np.uint8)


def ball(subdivisions=4, texture=None, *, welded=True):
    mesh = trimesh.creation.icosphere(subdivisions)
    points, triangles = mesh.vertices.astype(np.float32), mesh.faces.astype(np.int32)
    if not welded:  # as some files have it: three points for every triangle
        points = points[triangles].reshape(-1, 3)
        triangles = np.arange(len(points), dtype=np.int32).reshape(-1, 3)
    return Surface(points, triangles, points[:, :2].copy(), (9, 9, 9), texture)


@pytest.mark.parametrize("welded", [True, False])
def test_a_ball_stays_a_ball(welded):
    (made,) = simplified([ball(welded=welded)], 500)
    assert 400 <= len(made.triangles) <= 520
    corners = made.points[made.triangles]
    np.testing.assert_allclose(np.linalg.norm(made.points, axis=1), 1, atol=0.02)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normals, axis=1).sum() / 2
    assert area == pytest.approx(4 * np.pi, rel=0.03)
    assert (np.einsum("ij,ij->i", normals, corners.mean(axis=1)) > 0).mean() > 0.99  # still outward


def test_a_point_keeps_its_place_in_the_texture():
    (made,) = simplified([ball(texture=TEXTURE)], 500)
    assert np.abs(made.uv - made.points[:, :2]).max() < 0.15


def test_surfaces_give_up_the_same_share_and_a_box_keeps_its_sides():
    box = trimesh.creation.box()
    sides = Surface(
        box.vertices.astype(np.float32), box.faces.astype(np.int32), np.zeros((8, 2)), (1, 2, 3)
    )
    fine, coarse, same = simplified([ball(4), ball(3), sides], 1600)
    assert len(fine.triangles) == pytest.approx(4 * len(coarse.triangles), rel=0.1)
    assert same is sides


def test_a_model_that_is_coarse_enough_is_left_alone():
    surface = ball(2)
    assert simplified([surface], 4000) == (surface,)


def test_leaves_are_left_alone():
    leaf = ball(3)
    holed = Surface(
        leaf.points, leaf.triangles, leaf.uv, leaf.rgb, TEXTURE, np.ones((8, 8), np.bool_)
    )
    assert simplified([holed], 100) == (holed,)
