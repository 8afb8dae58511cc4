import numpy as np
import pytest

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.video_labels.footprint_masks import (
    drop_large_regions,
    footprint_pixels,
)

SIZE = (120, 160)
CAMERA = Intrinsics(130, 130, 79.5, 59.5)
EYE, TARGET = (0.0, 0.0, 1.6), (4.0, 0.0, 0.0)


@pytest.mark.parametrize("seed", range(10))
def test_it_finds_what_the_published_code_finds(shared, seed):
    folder = shared / "fixtures" / "reference"
    with np.load(folder / "label_inputs.npz") as given, np.load(folder / "label_expected.npz") as e:
        depth_m = given["depth"][given["target_index"]]
        (fx, _, cx, _), (_, fy, cy, _), *_ = (row.tolist() for row in given["intrinsics"])
        found = footprint_pixels(
            depth_m,
            given["ground_probability"],
            Intrinsics(fx, fy, cx, cy),
            seed,
            as_published=True,
        )
        expected = e["untraversable"]
    assert (found & expected).sum() / (found | expected).sum() >= 0.95


@pytest.fixture
def seen(scene, pose):
    """Depth and ground of a made-up scene; and where each ray meets the floor, x and y."""

    def view(*boxes):
        here = pose(EYE, TARGET)
        depth_m = scene(boxes).depth_m(here, CAMERA, SIZE)
        floor_m = scene().depth_m(here, CAMERA, SIZE)
        depth_m[depth_m > 15] = 0
        ground = ((depth_m > 0) & (np.abs(depth_m - floor_m) < 1e-3)).astype(np.float32)
        rows, columns = np.mgrid[: SIZE[0], : SIZE[1]].astype(float)
        rays = np.stack(
            [
                (columns - CAMERA.cx) / CAMERA.fx,
                (rows - CAMERA.cy) / CAMERA.fy,
                np.ones(SIZE),
            ],
            axis=-1,
        )
        on_floor = (rays * floor_m[..., None]) @ here[:3, :3].T + here[:3, 3]
        on_floor[floor_m == 0] = np.inf
        return depth_m, ground, on_floor[..., :2]

    return view


def within(points, low, high, margin_m):
    return ((points > np.array(low) - margin_m) & (points < np.array(high) + margin_m)).all(-1)


def test_the_foot_of_a_box_is_untraversable_and_nothing_else(seen, box):
    low, high = (3.0, -0.4), (3.6, 0.5)
    depth_m, ground, on_floor = seen(box((*low, 0.0), (*high, 1.0)))
    found = footprint_pixels(depth_m, ground, CAMERA)
    assert not (found & (ground > 0)).any()
    # the splat reaches 0.1 m around the box, and a pixel half of one more
    assert within(on_floor[found], low, high, 0.1 + 0.05).all()
    # of the box only its front is seen; a tenth of the depth behind it can be told
    front = within(on_floor, (3.0, -0.4), (3.3, 0.5), 0) & (ground == 0)
    assert front.sum() > 100
    assert found[front].mean() > 0.98


def test_a_thin_pole_leaves_its_foot(seen, box):
    low, high = (4.0, 0.2), (4.06, 0.26)
    depth_m, ground, on_floor = seen(box((*low, 0.0), (*high, 2.5)))
    found = footprint_pixels(depth_m, ground, CAMERA)
    assert 1 <= found.sum() < 60
    assert within(on_floor[found], low, high, 0.1 + 0.07).all()


def test_a_table_top_stands_on_nothing(seen, box):
    depth_m, ground, _ = seen(box((2.5, -0.6, 0.7), (3.5, 0.6, 0.75)))
    assert not footprint_pixels(depth_m, ground, CAMERA).any()


def test_without_ground_nothing_is_known(seen, box):
    depth_m, ground, _ = seen(box((3.0, -0.4, 0.0), (3.6, 0.5, 1.0)))
    few = np.zeros_like(ground)
    few.flat[np.flatnonzero(ground)[:90]] = 1
    assert not footprint_pixels(depth_m, few, CAMERA).any()


def test_only_small_regions_stay():
    mask = np.zeros((100, 100), bool)
    mask[:5, :5] = True  # 25 pixels
    mask[50:65, 50:65] = True  # 225: more than a hundredth
    kept = drop_large_regions(mask)
    assert kept[:5, :5].all()
    assert kept.sum() == 25
