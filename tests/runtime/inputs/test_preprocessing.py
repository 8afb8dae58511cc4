import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from footprints_edge.inputs import preprocessing
from footprints_edge.inputs.preprocessing import (
    BUDGET_PX,
    FILTERS,
    preprocess,
    resized,
    working_size,
)

SIDES = st.integers(1, 20_000)


@pytest.mark.parametrize(
    ("image_size", "expected"),
    [
        ((1080, 1920), (256, 448)),
        ((1920, 1080), (448, 256)),
        ((3000, 4000), (288, 384)),
        ((4000, 3000), (384, 288)),
        ((1, 1_000_000), (64, 2048)),
        ((1, 1), (352, 352)),
    ],
)
def test_sizes_of_common_pictures(image_size, expected):
    assert working_size(image_size) == expected


@given(SIDES, SIDES)
def test_every_size_is_a_multiple_of_32_within_budget_and_turns_with_the_picture(height, width):
    h, w = working_size((height, width))
    assert h % 32 == 0 and w % 32 == 0 and min(h, w) >= 32
    assert h * w <= 1.15 * BUDGET_PX
    assert working_size((width, height)) == (w, h)


@given(st.floats(1 / 3, 3))
def test_usual_shapes_are_squeezed_by_little_and_use_the_budget(aspect):
    h, w = working_size((1000, round(1000 * aspect)))
    assert w / h == pytest.approx(aspect, rel=0.16)
    assert h * w >= 0.75 * BUDGET_PX


@pytest.mark.parametrize(
    ("name", "resampling"),
    [
        ("lanczos", Image.Resampling.LANCZOS),
        ("hamming", Image.Resampling.HAMMING),
        ("bilinear", Image.Resampling.BILINEAR),
    ],
)
def test_preprocessing_is_pillows_resize(name, resampling):
    rgb = np.random.default_rng(0).integers(0, 256, (97, 131, 3), np.uint8)
    result = preprocess(rgb, (64, 96), name)
    assert result.dtype == np.uint8
    assert result.shape == (1, 64, 96, 3)
    np.testing.assert_array_equal(
        result[0], np.asarray(Image.fromarray(rgb).resize((96, 64), resampling))
    )


def hamming(t):
    t = np.minimum(np.abs(t), 1)  # its own value at 1 is 0
    return np.sinc(t) * (0.54 + 0.46 * np.cos(np.pi * t))


@pytest.mark.parametrize("size", [(64, 96), (120, 150)])
def test_hamming_is_the_formula_of_the_documentation(size):
    """docs/porting.md: along x, then along y, each rounded to bytes."""
    rgb = np.random.default_rng(0).integers(0, 256, (97, 131, 3), np.uint8)
    expected = rgb
    for axis, out in ((1, size[1]), (0, size[0])):
        scale = rgb.shape[axis] / out
        centre, j = (np.arange(out)[:, None] + 0.5) * scale, np.arange(rgb.shape[axis])
        weight = hamming((j + 0.5 - centre) / max(scale, 1))
        weight /= weight.sum(1, keepdims=True)
        expected = np.moveaxis(np.tensordot(weight, expected, (1, axis)), 0, axis)
        expected = np.clip(np.floor(expected + 0.5), 0, 255)
    off = np.abs(preprocess(rgb, size, "hamming")[0] - expected)
    assert off.max() <= 1
    assert off.mean() < 1e-3


@pytest.mark.parametrize("name", FILTERS)
def test_a_much_larger_picture_comes_out_as_if_it_were_resized_at_once(name):
    noise = np.random.default_rng(0).integers(0, 256, (75, 100, 3), np.uint8)
    rgb = np.asarray(Image.fromarray(noise).resize((2000, 1500), Image.Resampling.BICUBIC))
    exact = Image.fromarray(rgb).resize((192, 160), FILTERS[name])
    off = np.abs(preprocess(rgb, (160, 192), name)[0].astype(int) - np.asarray(exact))
    assert off.max() <= 3
    assert np.percentile(off, 99) <= 1


@given(st.integers(64, 5 * 64), st.integers(64, 5 * 96))
def test_a_picture_of_no_more_than_six_times_the_size_is_resized_at_once(height, width):
    rgb = np.random.default_rng(height).integers(0, 256, (height, width, 3), np.uint8)
    exact = Image.fromarray(rgb).resize((96, 64), Image.Resampling.LANCZOS)
    np.testing.assert_array_equal(preprocess(rgb, (64, 96))[0], np.asarray(exact))


@pytest.mark.parametrize("size", [(64, 96), (160, 192), (1499, 1999), (500, 40)])
@pytest.mark.parametrize("gap", [2.0, 3.0])
def test_very_large_pictures_come_out_the_same_in_strips(size, gap, monkeypatch):
    rgb = np.random.default_rng(0).integers(0, 256, (1499, 1999, 3), np.uint8)
    at_once = resized(rgb, size, reducing_gap=gap)
    monkeypatch.setattr(preprocessing, "_WHOLE_PX", 1000)
    monkeypatch.setattr(preprocessing, "_STRIP_PX", 50_000)
    np.testing.assert_array_equal(resized(rgb, size, reducing_gap=gap), at_once)


@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize(
    "image_size",
    [(720, 1280), (721, 1283), (1999, 1502), (97, 131), (1, 1), (200, 3000), (1600, 738)],
)
def test_threads_do_not_change_a_byte(image_size, name):
    rgb = np.random.default_rng(1).integers(0, 256, (*image_size, 3), np.uint8)
    for size in ((256, 448), (448, 256), (480, 224)):
        alone = preprocess(rgb, size, name)
        for threads in (2, 3):
            np.testing.assert_array_equal(preprocess(rgb, size, name, threads), alone)


@settings(deadline=None, max_examples=60)
@given(st.integers(33, 500), st.floats(0.9, 4), st.floats(0.8, 1.15))
def test_bands_go_the_way_that_pillow_goes(width, shrink, squeeze):
    """Which depends on the shape, and on Pillow's version."""
    wide, high = round(width * shrink), round(64 * shrink * squeeze)
    rgb = np.random.default_rng(2).integers(0, 256, (high, wide, 3), np.uint8)
    expected = Image.fromarray(rgb).resize((width, 64), Image.Resampling.LANCZOS, reducing_gap=3.0)
    np.testing.assert_array_equal(preprocess(rgb, (64, width), "lanczos", 2)[0], expected)
