"""Virtual cameras: whatever the view, its depths and labels are those of the same world."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.preprocessing import preprocess
from footprints_edge_models.data import augmentation
from footprints_edge_models.data.augmentation import draw_virtual_camera, render_view
from footprints_edge_models.networks.edge import FOCAL_PX
from footprints_edge_models.sample import FOOTPRINT, NO, UNKNOWN, UNLIKELY, UNSEEN, YES, Sample

SIZE = (90, 160)
CAMERA = Intrinsics(150.0, 170.0, 83.0, 41.0)
LABELS = np.array([NO, YES, UNSEEN, UNKNOWN, FOOTPRINT, UNLIKELY], np.uint8)

seeds = st.integers(0, 2**32 - 1)
view_sizes = st.sampled_from([(64, 96), (96, 64), (64, 64), (128, 224)])


def own_rays(camera, size):
    rows, columns = np.mgrid[: size[0], : size[1]].astype(float)
    return np.stack(
        [(columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy, np.ones(size)], -1
    )


def plane_sample(normal, offset_m, rng):
    """A picture of the plane normal . x = offset_m, random labels in blocks, smooth colours."""
    facing = own_rays(CAMERA, SIZE) @ normal
    depth_m = (offset_m / facing).astype(np.float16)
    blocks = (
        rng.integers(0, len(LABELS), (SIZE[0] // 10, SIZE[1] // 10)).repeat(10, 0).repeat(10, 1)
    )
    rows, columns = np.mgrid[: SIZE[0], : SIZE[1]]
    image = np.stack([rows, columns, rows + columns], -1).astype(np.uint8)
    visible = LABELS[blocks]
    visible[np.isin(visible, (UNSEEN, FOOTPRINT, UNLIKELY))] = NO
    return Sample(
        "plane",
        image,
        CAMERA,
        visible,
        LABELS[blocks.T.repeat(2)[: blocks.size].reshape(blocks.shape)],
        depth_m,
        depth_m * np.float16(0.5),
    )


def source_coordinates(view, size):
    """Where each pixel of a view (flip undone) is in the source picture: (u, v), closed form."""
    directions = own_rays(view.intrinsics, size) @ view.rotation  # rows: R^T ray
    u = CAMERA.fx * directions[..., 0] / directions[..., 2] + CAMERA.cx
    v = CAMERA.fy * directions[..., 1] / directions[..., 2] + CAMERA.cy
    return u, v


def unflipped(array, view):
    return array[:, ::-1] if view.flip else array


@settings(max_examples=60)
@given(
    seed=seeds,
    size=view_sizes,
    tilt=st.tuples(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6)),
    offset_m=st.floats(1.0, 12.0),
)
def test_back_projected_depths_lie_on_the_sample_s_own_plane(seed, size, tilt, offset_m):
    normal = np.array([*tilt, 1.0]) / np.linalg.norm([*tilt, 1.0])
    sample = plane_sample(normal, offset_m, np.random.default_rng(1))
    camera = draw_virtual_camera(sample, size, np.random.default_rng(seed))
    view = render_view(sample, size, np.random.default_rng(seed))
    # The nearest source pixel is up to half a pixel off along both axes; halves of floats add
    # 2^-11. How fast the depth of this plane changes is known.
    slope = np.abs(tilt).sum() / 150 / (own_rays(CAMERA, SIZE) @ normal).min()
    allowed = 2**-11 + 0.55 * slope + 1e-4
    for canonical_m, factor in ((view.visible_depth_m, 1.0), (view.ground_depth_m, 0.5)):
        depth_m = unflipped(canonical_m, camera) * camera.intrinsics.focal_px / FOCAL_PX
        points = own_rays(camera.intrinsics, size) * depth_m[..., None] @ camera.rotation
        known = depth_m > 0
        assert known.mean() > 0.9
        relative = points[known] @ normal / (factor * offset_m) - 1
        assert np.abs(relative).max() <= allowed + 2**-11


@settings(max_examples=40)
@given(seed=seeds, size=view_sizes)
def test_labels_move_with_their_pixels(seed, size):
    sample = plane_sample(np.array([0, 0, 1.0]), 3.0, np.random.default_rng(seed % 7))
    camera = draw_virtual_camera(sample, size, np.random.default_rng(seed))
    view = render_view(sample, size, np.random.default_rng(seed))
    u, v = source_coordinates(camera, size)
    # A sixteenth of a pixel around the ties is OpenCV's to decide.
    sure = (np.abs(u % 1 - 0.5) > 0.07) & (np.abs(v % 1 - 0.5) > 0.07)
    columns, rows = np.rint(u).astype(int), np.rint(v).astype(int)
    inside = (columns >= 0) & (rows >= 0) & (columns < SIZE[1]) & (rows < SIZE[0])
    visible, ground = np.full((2, *size), UNKNOWN)
    visible[inside] = sample.visible_ground[rows[inside], columns[inside]]
    ground[inside] = sample.ground[rows[inside], columns[inside]]
    for found, expected in (
        (view.visible_ground, visible == YES),
        (view.visible_ground_valid, visible != UNKNOWN),
        (view.ground, ground == YES),
        (view.untraversable, (ground == NO) + 3.0 * (ground == FOOTPRINT)),
        (view.unknown_weight, 0.25 * ((ground == UNSEEN) | (ground == UNLIKELY))),
    ):
        np.testing.assert_array_equal(unflipped(found, camera)[sure], expected[sure])
    assert not view.moving.any()


def test_moving_objects_move_with_their_pixels():
    sample = plane_sample(np.array([0, 0, 1.0]), 3.0, np.random.default_rng(0))
    sample = replace(sample, moving=(sample.ground == YES).astype(np.uint8))
    for seed in range(5):
        view = render_view(sample, (96, 160), np.random.default_rng(seed))
        assert view.moving.any()
        np.testing.assert_array_equal(view.moving, view.ground)


@settings(max_examples=40)
@given(seed=seeds, size=view_sizes)
def test_the_picture_moves_with_the_same_pixels(seed, size):
    sample = plane_sample(np.array([0, 0, 1.0]), 3.0, np.random.default_rng(0))
    camera = draw_virtual_camera(sample, size, np.random.default_rng(seed))
    with pytest.MonkeyPatch.context() as patch:
        for name in ("jitter_colours", "degraded"):
            patch.setattr(augmentation, name, lambda image, _: image)
        image = render_view(sample, size, np.random.default_rng(seed)).image
    u, v = source_coordinates(camera, size)
    inside = (u >= 4) & (v >= 4) & (u <= SIZE[1] - 5) & (v <= SIZE[0] - 5)
    inside[:4], inside[-4:], inside[:, :4], inside[:, -4:] = (False,) * 4
    # The sample's colours are its rows, its columns and their sum: a symmetric filter is exact
    # where it does not reach over a border.
    expected = np.stack([v, u, u + v], -1)[inside]
    error = unflipped(image, camera)[inside] - expected
    assert np.abs(error).max() <= 1.7  # rounded to whole colours before and after the filter
    assert np.abs(error.mean(axis=0)).max() <= 0.25  # half a pixel off would be half a colour


@pytest.mark.parametrize("size", [(90, 160), (45, 80), (30, 53)])
def test_the_whole_picture_is_shrunk_as_the_runtime_shrinks_it(size):
    image = np.random.default_rng(0).integers(0, 256, (*SIZE, 3)).astype(np.uint8)
    sample = replace(blank_sample(Intrinsics.assumed(SIZE)), image=image)
    expected = preprocess(image, size)[0].astype(int)
    difference = np.abs(render_view(sample, size).image - expected)[3:-3, 3:-3]
    assert difference.mean() < 4  # plain bilinear sampling of noise is 30 away


def test_stripes_finer_than_a_view_s_pixels_become_grey():
    image = np.zeros((*SIZE, 3), np.uint8)
    image[:, ::2] = 200
    sample = replace(blank_sample(Intrinsics.assumed(SIZE)), image=image)
    with pytest.MonkeyPatch.context() as patch:
        for name in ("jitter_colours", "degraded"):
            patch.setattr(augmentation, name, lambda image, _: image)
        views = [render_view(sample, (24, 40), np.random.default_rng(s)).image for s in range(8)]
    for view in views:
        assert np.abs(view[2:-2, 2:-2].astype(int) - 100).max() < 25


def blank_sample(camera):
    blank = np.zeros(SIZE, np.uint8)
    return Sample("blank", np.zeros((*SIZE, 3), np.uint8), camera, blank, blank)


def seen_by(view, camera, size):
    """The extremes of a view in the sample's picture: (left, top, right, bottom)."""
    directions = own_rays(view.intrinsics, size) @ view.rotation
    u = camera.fx * directions[..., 0] / directions[..., 2] + camera.cx
    v = camera.fy * directions[..., 1] / directions[..., 2] + camera.cy
    return u.min(), v.min(), u.max(), v.max()


@pytest.mark.parametrize(
    ("size", "seen"),
    [((90, 160), (0, 0, 159, 89)), ((96, 96), (35, 0, 124, 89)), ((64, 224), (0, 22, 159, 67))],
)
def test_without_a_generator_the_view_is_the_largest_central_one(size, seen):
    camera = Intrinsics.assumed(SIZE)
    view = draw_virtual_camera(blank_sample(camera), size, None)
    assert not view.flip
    assert seen_by(view, camera, size) == pytest.approx(seen, abs=1)


def test_without_a_generator_the_view_is_always_the_same():
    sample = plane_sample(np.array([0, 0, 1.0]), 3.0, np.random.default_rng(0))
    first, second = render_view(sample, (96, 96)), render_view(sample, (96, 96))
    for name in augmentation.VirtualView.__dataclass_fields__:
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_the_same_seed_gives_the_same_view_and_another_one_another():
    sample = plane_sample(np.array([0, 0, 1.0]), 3.0, np.random.default_rng(0))
    images = [render_view(sample, (64, 96), np.random.default_rng(s)).image for s in (5, 5, 6)]
    np.testing.assert_array_equal(images[0], images[1])
    assert (images[0] != images[2]).any()


class NoRoll(np.random.Generator):
    """A generator whose normal draws are all zero: no roll, whatever else is random."""

    def normal(self, _loc=0.0, _scale=1.0, size=None):
        return 0.0 if size is None else np.zeros(size)


@pytest.mark.parametrize(
    "camera",
    [Intrinsics.assumed(SIZE), Intrinsics(150.0, 170.0, 79.5, 44.5)],
    ids=["assumed", "unequal-focal-lengths"],
)
@settings(max_examples=60)
@given(seed=seeds, size=view_sizes)
def test_without_roll_little_of_a_view_lies_outside_the_picture(camera, seed, size):
    view = render_view(blank_sample(camera), size, NoRoll(np.random.PCG64(seed)))
    assert view.visible_ground_valid.mean() > 0.75


def test_a_sample_without_depths_has_none_in_its_view():
    sample = blank_sample(CAMERA)
    view = render_view(sample, (64, 96), np.random.default_rng(0))
    assert not view.visible_depth_m.any()
    assert not view.ground_depth_m.any()


def test_jitter_changes_colours_and_keeps_the_picture():
    rng = np.random.default_rng(0)
    image = np.zeros((40, 60, 3), np.uint8)
    image[:, 30:] = (200, 150, 100)
    changed = [augmentation.jitter_colours(image, rng) for _ in range(20)]
    assert any((picture != image).any() for picture in changed)
    for picture in changed:
        assert picture.shape == image.shape
        assert picture.dtype == np.uint8
        left, right = picture[:, :25].mean(), picture[:, 35:].mean()
        assert right > left + 20  # the bright half stays the bright one
