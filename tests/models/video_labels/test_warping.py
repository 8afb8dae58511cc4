import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.video_labels.warping import aggregate, warp_depth

CAMERA = Intrinsics(60, 62, 31.5, 23.5)
SIZE = (48, 64)


@pytest.fixture(scope="module")
def published(shared):
    """The made-up scene of seven frames, and the labels that the paper's code gives."""
    folder = shared / "fixtures" / "reference"
    with np.load(folder / "label_inputs.npz") as given, np.load(folder / "label_expected.npz") as e:
        return dict(given) | dict(e)


def lands_inside(depth_m, camera, pose):
    """Which of the points of a picture the other camera sees; not those on row or column 0."""
    rows, columns = np.nonzero(depth_m)
    z = depth_m[rows, columns]
    x, y = (columns - camera.cx) / camera.fx * z, (rows - camera.cy) / camera.fy * z
    x, y, z, _ = pose @ np.stack([x, y, z, np.ones_like(z)])
    u, v = camera.fx * x / z + camera.cx, camera.fy * y / z + camera.cy
    height, width = depth_m.shape
    tiny = 1e-6  # what rounding makes of a point on row 0
    return (z > 0) & (u > tiny) & (v > tiny) & (u < width) & (v < height)


def published_warps(scene):
    """The paper's warps: seven of them, as a scatter in two threads leaves them.

    The code scatters a frame's points with one torch assignment. The fixture was made with two
    threads, each taking half of the points in row-major order, and where points of both halves
    meet a pixel the first half came last. Warped one by one, the halves can be laid so.
    """
    (fx, _, cx, _), (_, fy, cy, _), *_ = scene["intrinsics"]
    camera = Intrinsics(float(fx), float(fy), float(cx), float(cy))
    size = scene["depth"].shape[1:]

    def warp(depth_m, pose):
        return warp_depth(depth_m, camera, camera, pose, size, as_published=True)

    plain, threaded = [], []
    ground_m = np.where(scene["ground"] > 0.75, scene["depth"], 0).astype(np.float32)
    for depth_m, pose in zip(ground_m, scene["camera_to_target"], strict=True):
        plain.append(warp(depth_m, pose))
        pixels = np.flatnonzero(depth_m)[lands_inside(depth_m, camera, pose)]
        first, second = np.zeros_like(depth_m), np.zeros_like(depth_m)
        half = -(-len(pixels) // 2)
        first.flat[pixels[:half]] = depth_m.flat[pixels[:half]]
        second.flat[pixels[half:]] = depth_m.flat[pixels[half:]]
        laid_last = warp(first, pose)
        threaded.append(np.where(laid_last > 0, laid_last, warp(second, pose)))
    return np.stack(plain), np.stack(threaded)


def test_ground_depth_equals_the_published_codes(published):
    plain, threaded = published_warps(published)
    for least_hits, name in ((2, "hidden_depth_robust"), (0, "hidden_depth_plain")):
        expected = published[name]
        np.testing.assert_allclose(aggregate(threaded, least_hits), expected, rtol=1e-6)
        ours = aggregate(plain, least_hits)
        np.testing.assert_array_equal(ours > 0, expected > 0)
        # ours keeps the last point whatever the threads do: a hundredth of the pixels differ
        differ = np.abs(ours - expected) > 1e-4
        assert differ.sum() < 0.01 * (expected > 0).sum()
        assert np.abs(ours - expected).max() < 0.25


def test_a_frame_warped_into_itself_stays():
    depth_m = np.random.default_rng(0).uniform(0.5, 30, SIZE).astype(np.float32)
    depth_m[::5] = 0
    warped = warp_depth(depth_m, CAMERA, CAMERA, np.eye(4), SIZE)
    np.testing.assert_allclose(warped, depth_m, rtol=1e-6)


def test_every_floor_point_lands_where_the_other_camera_sees_it(scene, pose):
    """In closed form: rays meet the floor z = 0, and the other camera projects that point."""
    here, other = pose((0, 0, 1.5), (4, 0, 0)), pose((1, 0.6, 1.1), (4, 0.4, 0))
    depth_m = scene().depth_m(here, CAMERA, SIZE)
    depth_m[depth_m > 20] = 0
    warped = warp_depth(depth_m, CAMERA, CAMERA, np.linalg.inv(other) @ here, SIZE)

    expected = np.full(SIZE, np.inf)
    for row, column in np.argwhere(depth_m > 0):
        ray = np.array([(column - CAMERA.cx) / CAMERA.fx, (row - CAMERA.cy) / CAMERA.fy, 1])
        down = here[:3, :3] @ ray
        point = here[:3, 3] - down * here[2, 3] / down[2]
        x, y, z = other[:3, :3].T @ (point - other[:3, 3])
        u, v = round(CAMERA.fx * x / z + CAMERA.cx), round(CAMERA.fy * y / z + CAMERA.cy)
        if z > 0 and 0 <= v < SIZE[0] and 0 <= u < SIZE[1]:
            expected[v, u] = min(expected[v, u], z)
    expected[np.isinf(expected)] = 0
    assert (expected > 0).sum() > 500
    np.testing.assert_allclose(warped, expected, atol=1e-3)

    # and that is the floor that the other camera sees there, to half a pixel
    low = scene().depth_m(other, Intrinsics(60, 62, 31.5, 23.0), SIZE)
    high = scene().depth_m(other, Intrinsics(60, 62, 31.5, 24.0), SIZE)
    hit = (warped > 0) & (high > 0)
    assert (warped[hit] >= low[hit] - 1e-3).all()
    assert (warped[hit] <= high[hit] + 1e-3).all()


def test_the_nearer_of_two_points_covers_the_farther():
    # two pixels side by side; the camera shrinks the picture so much that they meet in one
    depth_m = np.zeros(SIZE, np.float32)
    depth_m[20, 30:32] = 2.0, 9.0
    wide = Intrinsics(6, 6, 31.5, 23.5)
    warped = warp_depth(depth_m, CAMERA, wide, np.eye(4), SIZE)
    assert warped[warped > 0].tolist() == [2.0]
    as_published = warp_depth(depth_m, CAMERA, wide, np.eye(4), SIZE, as_published=True)
    assert as_published[as_published > 0].tolist() == [9.0]  # the last in row-major order


def test_points_behind_the_camera_and_beside_the_picture_are_left_out():
    depth_m = np.full(SIZE, 2.0, np.float32)
    turned = np.diag([-1.0, 1.0, -1.0, 1.0])
    assert not warp_depth(depth_m, CAMERA, CAMERA, turned, SIZE).any()
    aside = np.eye(4)
    aside[0, 3] = 50
    assert not warp_depth(depth_m, CAMERA, CAMERA, aside, SIZE).any()


@given(st.integers(1, 9), st.integers(0, 3), st.integers(0, 10**6))
def test_aggregation_is_numpys_masked_median(count, least_hits, seed):
    rng = np.random.default_rng(seed)
    stack = rng.uniform(0.5, 20, (count, 5, 7)) * (rng.random((count, 5, 7)) < 0.6)
    stack = stack.astype(np.float32)
    expected = np.ma.median(np.ma.masked_equal(stack, 0), axis=0).filled(0)
    expected[(stack > 0).sum(axis=0) <= least_hits] = 0
    np.testing.assert_allclose(aggregate(stack, least_hits), expected, rtol=1e-6)
