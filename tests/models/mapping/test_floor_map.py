"""Floor maps of made-up rooms, against what the rooms are made of."""

import numpy as np
import pytest

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_models.mapping.floor_map import (
    FREE,
    NEVER_SEEN,
    OCCUPIED,
    OVERHUNG,
    DepthFrame,
    build_floor_map,
    fit_floor,
)
from footprints_edge_models.mapping.planes import Plane

SIZE = (180, 240)
CAMERA = Intrinsics(160.0, 160.0, 119.5, 89.5)
EYES = [(-2.5, 0.0, 1.5), (2.5, 0.3, 1.5), (0.2, -2.5, 1.5), (0.0, 2.5, 1.5)]
FLOOR = Plane(np.array([0.0, 0.0, 1.0]), 0.0)
UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture
def frames_of(pose):
    """Frames of a scene from cameras 1.5 m above its floor that look at its middle."""

    def frames(scene, eyes=EYES):
        poses = [pose(eye, (0, 0, 0.2)) for eye in eyes]
        return [DepthFrame(scene.depth_m(p, CAMERA, SIZE), CAMERA, p) for p in poses]

    return frames


def floor_points(frame):
    """World point where each ray meets the floor, and its depth: closed form."""
    rows, columns = np.mgrid[: SIZE[0], : SIZE[1]].astype(float)
    x, y = (columns - CAMERA.cx) / CAMERA.fx, (rows - CAMERA.cy) / CAMERA.fy
    pose = frame.camera_to_world
    directions = np.stack([x, y, np.ones_like(x)], -1) @ pose[:3, :3].T
    with np.errstate(divide="ignore"):
        depth_m = np.where(directions[..., 2] < -1e-6, -pose[2, 3] / directions[..., 2], 0)
    return pose[:3, 3] + depth_m[..., None] * directions, depth_m


def within(points, box, margin_m=0.0):
    x, y = points[..., 0], points[..., 1]
    low, high = box.low, box.high
    return (
        (x > low[0] - margin_m)
        & (x < high[0] + margin_m)
        & (y > low[1] - margin_m)
        & (y < high[1] + margin_m)
    )


def test_a_box_is_occupied_and_the_floor_behind_it_free(scene, box, frames_of):
    crate = box((-0.4, -0.3, 0), (0.4, 0.3, 0.6))
    frames = frames_of(scene((crate,)))
    floor_map = build_floor_map(frames, FLOOR)
    for frame in frames:
        cells, depth_m = floor_map.project(frame)
        points, expected_m = floor_points(frame)
        np.testing.assert_allclose(depth_m, expected_m, rtol=1e-4, atol=1e-5)

        core = within(points, crate, -0.06) & (depth_m > 0)
        assert core.any()
        assert (cells[core] == OCCUPIED).mean() > 0.98

        around = within(points, box((-1.2, -1.2, 0), (1.2, 1.2, 0))) & (depth_m > 0)
        around &= ~within(points, crate, 0.08)
        hidden = around & (frame.depth_m < depth_m - 0.05)
        assert hidden.any()  # this camera does not see it, another one does
        assert (cells[hidden] == FREE).mean() > 0.98
        assert (cells[around & ~hidden] == FREE).mean() > 0.98


def test_floor_that_no_camera_saw_is_never_seen(scene, box, frames_of):
    wall = box((-0.4, -8, 0), (-0.2, 8, 2.5))
    frames = frames_of(scene((wall,)), EYES[:1])
    cells, depth_m = build_floor_map(frames, FLOOR).project(frames[0])
    points, _ = floor_points(frames[0])
    behind = (depth_m > 0) & (points[..., 0] > 0)
    assert behind.any()
    assert (cells[behind] == NEVER_SEEN).all()
    before = (depth_m > 0) & (points[..., 0] < -0.5)
    assert (cells[before] == FREE).mean() > 0.97


def test_floor_under_a_table_top_is_free(scene, box, frames_of):
    """Two low cameras see beneath it; the four that see its top, far better, take nothing away."""
    table = box((-0.6, -0.6, 0.7), (0.6, 0.6, 0.75))
    low = [(-1.5, 0, 0.5), (1.5, 0.1, 0.5)]
    high = [(-1.5, 0, 1.7), (1.5, 0, 1.7), (0, -1.5, 1.7), (0, 1.5, 1.7)]
    frames = frames_of(scene((table,)), low + high)
    cells, depth_m = build_floor_map(frames, FLOOR).project(frames[0])
    points, _ = floor_points(frames[0])
    under = within(points, table, -0.15) & (depth_m > 0)
    assert (cells[under] == FREE).mean() > 0.95


@pytest.mark.parametrize(
    ("low_m", "cell"),
    [(0.1, OCCUPIED), (1.0, OVERHUNG), (1.9, NEVER_SEEN)],
    ids=["step", "shelf", "lamp"],
)
def test_a_person_passes_beneath_what_hangs_high(scene, box, frames_of, low_m, cell):
    """Where nobody saw the floor, what is above it decides."""
    thing = box((-0.3, -0.3, low_m), (0.3, 0.3, low_m + 0.1))
    frames = frames_of(scene((thing,)), [(x, y, 2.6) for x, y, _ in EYES])
    for frame in frames:
        points, depth_m = floor_points(frame)
        frame.depth_m[within(points, thing, 0.1) & (np.abs(frame.depth_m - depth_m) < 0.01)] = 0
    cells, depth_m = build_floor_map(frames, FLOOR).project(frames[0])
    core = within(floor_points(frames[0])[0], thing, -0.06) & (depth_m > 0)
    assert (cells[core] == cell).mean() > 0.98


def test_beneath_a_counter_is_no_floor(scene, box, frames_of):
    """Its inside was seen from above only, as a table's is; but its front reaches the floor."""
    counter = box((-0.5, -0.5, 0), (0.5, 0.5, 0.9))
    frames = frames_of(scene((counter,)))
    cells, depth_m = build_floor_map(frames, FLOOR).project(frames[0])
    inside = within(floor_points(frames[0])[0], counter, -0.1) & (depth_m > 0)
    assert (cells[inside] == OCCUPIED).mean() > 0.95


def test_floor_within_a_solid_thing_is_noise(scene, box, frames_of):
    """A strip of two cells inside a block: the sensor errs, nobody stands there."""
    block = box((-0.4, -0.4, 0), (0.4, 0.4, 0.3))
    frames = frames_of(scene((block,)))
    points, depth_m = floor_points(frames[0])
    strip = within(points, box((-0.04, -0.3, 0), (0.0, 0.3, 0))) & (depth_m > 0)
    frames += [
        DepthFrame(
            np.where(strip, depth_m, 0).astype(np.float32), CAMERA, frames[0].camera_to_world
        )
    ] * 9
    cells, _ = build_floor_map(frames, FLOOR).project(frames[0])
    assert strip.any()
    assert not (cells[strip] == FREE).any()


def test_no_floor_above_the_horizon(scene, frames_of, pose):
    level = pose((0, 0, 1.5), (1, 0, 1.5))
    floor_map = build_floor_map(frames_of(scene()), FLOOR)
    cells, depth_m = floor_map.project(DepthFrame(np.zeros(SIZE, np.float32), CAMERA, level))
    assert not depth_m[: SIZE[0] // 2].any()
    assert not cells[: SIZE[0] // 2].any()
    bottom = 1.5 * CAMERA.fy / (SIZE[0] - 1 - CAMERA.cy)
    np.testing.assert_allclose(depth_m[-1], bottom, rtol=1e-4)


@pytest.mark.parametrize("tilt_deg", [0.0, 1.0, 2.0])
@pytest.mark.parametrize("noise_m", [0.0, 0.005])
def test_a_tilted_floor_is_found(scene, box, frames_of, tilt_deg, noise_m):
    rng = np.random.default_rng(0)
    crate = box((-0.4, -0.3, 0), (0.4, 0.3, 0.6))
    frames = frames_of(scene((crate,)))
    frames = [
        DepthFrame(
            np.where(
                (f.depth_m > 0) & (f.depth_m < 5),
                f.depth_m + rng.normal(0, noise_m, SIZE),
                0,
            ).astype(np.float32),
            f.intrinsics,
            f.camera_to_world,
        )
        for f in frames
    ]
    # The gravity that the clip states is off by so much; the floor is where it is.
    angle = np.radians(tilt_deg)
    plane = fit_floor(frames, 9.8 * np.array([np.sin(angle), 0, np.cos(angle)]))
    assert np.degrees(np.arccos(min(1, plane.normal @ UP))) < 0.2
    assert plane.offset_m == pytest.approx(0, abs=0.01)
    assert np.linalg.norm(plane.normal) == pytest.approx(1)


def test_a_table_top_is_not_the_floor(scene, box, frames_of):
    frames = frames_of(scene((box((-1, -1, 0.7), (1, 1, 0.75)),)))
    near = [
        DepthFrame(np.where(f.depth_m < 6, f.depth_m, 0), f.intrinsics, f.camera_to_world)
        for f in frames
    ]
    assert fit_floor(near, UP).offset_m == pytest.approx(0, abs=0.01)


@pytest.mark.parametrize("normal", [(0, 0, 1), (1, 0, 0), (0.2, -0.9, 0.3)])
def test_a_plane_s_axes_lie_in_it(normal):
    normal = np.array(normal) / np.linalg.norm(normal)
    plane = Plane(normal, 0.7)
    basis = np.stack([*plane.axes(), normal])
    np.testing.assert_allclose(basis @ basis.T, np.eye(3), atol=1e-12)
    first, second = plane.axes()
    on_plane = 0.7 * normal + 3 * first - 2 * second
    assert plane.height_m(on_plane) == pytest.approx(0)
    assert plane.height_m(on_plane + 1.5 * normal) == pytest.approx(1.5)
