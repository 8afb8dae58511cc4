"""Voxel grids and their floor, in closed form."""

import numpy as np
import pytest
from baseline_shapes import voxel_room

from footprints_edge_bench.geometry.voxels import VoxelGrid, VoxelsError, read_voxels

SIZE = (120, 160)


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
