"""Ground truth of RGB-D clips."""

import numpy as np

from footprints_edge_bench.geometry.convex_hull import convex_hull
from footprints_edge_bench.ground_truth.datasets import (
    ReadingOptions,
    Subset,
    open_folder,
)

ALL = Subset()


def loaded(dataset):
    return {item.name: item.load() for item in dataset.items}


def test_ground_truth_is_what_the_whole_clip_saw(clip, camera, pose, floor_of):
    (dataset,) = open_folder(clip, ReadingOptions(), ALL)
    assert dataset.kind == "clip"
    ground_truths = loaded(dataset)
    assert list(ground_truths) == [f"walk/f{i}" for i in range(10)]
    ground_truth = ground_truths["walk/f0"]
    assert ground_truth.image == clip / "images" / "f0.jpg"
    assert ground_truth.intrinsics == camera
    points, floor_m = floor_of(pose(down_deg=35, x=-1.0))
    x, y = points[..., 0], points[..., 1]

    def crate(margin_m):
        return (np.abs(x) < 0.3 + margin_m) & (np.abs(y - 1.9) < 0.2 + margin_m)

    inside, around = crate(-0.06), crate(0.5) & ~crate(0.1)
    assert ground_truth.ground.valid[inside].mean() > 0.95
    assert not ground_truth.ground.mask[inside].any()
    valid = ground_truth.ground.valid
    assert ground_truth.ground.mask[around & valid].mean() > 0.99
    assert valid[around & (y < 2.1)].mean() > 0.99
    hidden = around & valid & (ground_truth.visible_depth_m < floor_m - 0.1)
    assert hidden.sum() > 30  # this frame does not see it, others do
    assert not ground_truth.visible_ground.mask[hidden].any()
    known_m = ground_truth.ground_depth_m[ground_truth.ground.mask]
    np.testing.assert_allclose(known_m, floor_m[ground_truth.ground.mask], rtol=1e-3)
    assert (ground_truth.ground_depth_m[~ground_truth.ground.mask] == 0).all()
    # far away nobody saw anything; above the horizon is no ground
    assert not ground_truth.ground.valid[(floor_m > 12)].any()
    above = floor_m == 0
    assert ground_truth.ground.valid[above].all() and not ground_truth.ground.mask[above].any()
    np.testing.assert_array_equal(
        ground_truth.region, convex_hull(ground_truth.visible_ground.mask)
    )
