import io
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from footprints_edge import Intrinsics, load
from footprints_edge.errors import ModelError
from footprints_edge.inputs.preprocessing import preprocess

MAPS = (
    "visible_ground",
    "ground",
    "hidden_ground",
    "visible_depth_m",
    "ground_depth_m",
    "visible_ground_probability",
    "ground_probability",
)


@pytest.fixture
def load_with(tmp_path, metadata, model_bytes):
    """Loads a tiny model with other metadata, or fixed to a size."""

    def load_changed(size=("H", "W"), **changes):
        path = tmp_path / "changed.onnx"
        path.write_bytes(model_bytes(size, replace(metadata, **changes)))
        return load(path, threads=1)

    return load_changed


def test_the_maps_are_the_networks(tiny, picture):
    prediction = tiny.predict(picture, flatten=False)
    seen = preprocess(picture, tiny.input_size((60, 100)))[0] / np.float32(255)
    red, green, blue = np.moveaxis(seen, -1, 0)
    ground = np.clip(red + green, 0, 1)
    np.testing.assert_allclose(prediction.visible_ground_probability, green, atol=1e-5)
    np.testing.assert_allclose(prediction.ground_probability, ground, atol=1e-5)
    np.testing.assert_allclose(prediction.visible_depth_m, 1 / (0.01 + 9.99 * blue), rtol=1e-4)
    expected_m = np.where(ground > 0.5, 1 / (0.01 + 9.99 * blue / 2), np.nan)
    np.testing.assert_allclose(prediction.ground_depth_m, expected_m, rtol=1e-4)


def test_shapes_dtypes_and_facts(tiny, tiny_path, picture):
    prediction = tiny.predict(picture)
    h, w = tiny.input_size((60, 100))
    assert prediction.image_size == (60, 100)
    for name in MAPS:
        array = getattr(prediction, name)
        assert array.shape == (h, w)
        assert array.dtype == (bool if name.endswith("ground") else np.float32), name
    assert list(prediction.timings_ms) == ["decode", "preprocess", "inference", "postprocess"]
    assert all(ms >= 0 for ms in prediction.timings_ms.values())
    assert (tiny.path, tiny.name, prediction.model.sha256) == (tiny_path, "tiny", tiny.sha256)


def test_hidden_ground_is_ground_that_is_not_seen(tiny, picture):
    prediction = tiny.predict(picture)
    assert prediction.hidden_ground.any()
    assert prediction.visible_ground.any()
    np.testing.assert_array_equal(
        prediction.hidden_ground, prediction.ground & ~prediction.visible_ground
    )
    np.testing.assert_array_equal(np.isnan(prediction.ground_depth_m), ~prediction.ground)


def test_a_fixed_model_sees_every_picture_at_its_size(load_with, picture):
    model = load_with(size=(64, 32))
    prediction = model.predict(picture)
    assert prediction.ground.shape == (64, 32)
    green = preprocess(picture, (64, 32))[0, ..., 1] / 255
    np.testing.assert_allclose(prediction.visible_ground_probability, green, atol=1e-5)


def test_every_source_gives_the_same_prediction(tiny, picture, tmp_path):
    path = tmp_path / "a.png"
    Image.fromarray(picture).save(path)
    expected = tiny.predict(picture)
    with path.open("rb") as file:
        for source in (path, str(path), path.read_bytes(), file, Image.open(path)):
            actual = tiny.predict(source)
            for name in MAPS:
                np.testing.assert_array_equal(getattr(actual, name), getattr(expected, name))


def test_metres_scale_with_the_focal_length_in_the_networks_pixels(load_with, picture):
    model = load_with(focal_px=400.0)
    h, w = model.input_size((60, 100))
    camera = Intrinsics(80, 90, 40, 30)
    prediction = model.predict(picture, intrinsics=camera)
    focal_px = np.sqrt(80 * w / 100 * 90 * h / 60)
    as_trained = load_with(focal_px=None).predict(picture, intrinsics=camera)
    np.testing.assert_allclose(
        prediction.visible_depth_m, as_trained.visible_depth_m * focal_px / 400, rtol=1e-5
    )
    np.testing.assert_allclose(
        prediction.ground_depth_m, as_trained.ground_depth_m * focal_px / 400, rtol=1e-5
    )


def test_the_depth_range_is_the_files(load_with):
    black = load_with(depth_range_m=(0.5, 40.0)).predict(np.zeros((9, 9, 3), np.uint8))
    np.testing.assert_allclose(black.visible_depth_m, 40, rtol=1e-6)


def jpeg(picture, focal_35mm):
    exif = Image.Exif()
    if focal_35mm:
        exif.get_ifd(0x8769)[0xA405] = focal_35mm
    buffer = io.BytesIO()
    Image.fromarray(picture).save(buffer, "JPEG", exif=exif)
    return buffer.getvalue()


def test_the_camera_is_the_given_one_then_exifs_then_assumed(tiny, picture):
    size, maps = (60, 100), tiny.input_size((60, 100))
    given = Intrinsics(80, 90, 40, 30)
    cases = [
        (jpeg(picture, 26), given, given),
        (
            jpeg(picture, 26),
            lambda size: Intrinsics.from_hfov(70, size),
            Intrinsics.from_hfov(70, size),
        ),
        (jpeg(picture, 26), None, Intrinsics.from_focal_35mm(26, size)),
        (jpeg(picture, None), None, Intrinsics.assumed(size)),
        (picture, None, Intrinsics.assumed(size)),
    ]
    for source, intrinsics, expected in cases:
        prediction = tiny.predict(source, intrinsics=intrinsics)
        assert prediction.intrinsics == expected.scaled(size, maps)
    assert [expected.source for *_, expected in cases] == [
        "given",
        "given",
        "exif",
        "assumed",
        "assumed",
    ]


def test_the_threshold_is_a_probability(tiny):
    half = np.full((352, 352, 3), (0, 128, 0), np.uint8)  # visible ground probability 0.502
    assert tiny.predict(half).visible_ground.all()
    strict = tiny.predict(half, threshold=0.51)
    assert not (strict.visible_ground | strict.ground).any()
    assert tiny.predict(half).ground.all()
    for threshold in (-0.1, 1.1, float("nan")):
        with pytest.raises(ValueError, match="probability"):
            tiny.predict(half, threshold=threshold)


def test_many_threads_get_the_same_results_as_one(tiny):
    rng = np.random.default_rng(0)
    pictures = [rng.integers(0, 256, (h, 90, 3), np.uint8) for h in range(40, 200, 10)]
    expected = [tiny.predict(picture) for picture in pictures]
    with ThreadPoolExecutor(8) as pool:
        for _ in range(3):
            for actual, one in zip(pool.map(tiny.predict, pictures), expected, strict=True):
                np.testing.assert_array_equal(actual.ground_depth_m, one.ground_depth_m)
                np.testing.assert_array_equal(actual.visible_depth_m, one.visible_depth_m)


def test_files_without_metadata_are_refused(tmp_path, model_bytes):
    path = tmp_path / "bare.onnx"
    path.write_bytes(model_bytes(props={}))
    with pytest.raises(ModelError, match=r"bare\.onnx.*fp-export convert"):
        load(path)


def test_unknown_filters_and_odd_sizes_are_refused(load_with):
    with pytest.raises(ModelError, match="'nearest'"):
        load_with(resize="nearest")
    with pytest.raises(ModelError, match="multiples of 32"):
        load_with(size=(64, 33))


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs Linux's /proc")
def test_memory_stays_where_it_is(tiny):
    def resident_mb():
        return (
            int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
        )

    rng = np.random.default_rng(0)
    for count in range(200):
        tiny.predict(rng.integers(0, 256, (*rng.integers(50, 400, 2), 3), np.uint8))
        if count == 40:
            before_mb = resident_mb()
    assert resident_mb() - before_mb < 25


def test_a_file_with_fewer_maps_than_it_says_is_refused(load_with, picture):
    with pytest.raises(ModelError, match=r"gives 4 maps, but its metadata states .*outputs=masks"):
        load_with(outputs="masks").predict(picture)


def test_an_unknown_engine_is_refused_with_the_known_ones(tiny_path):
    with pytest.raises(ModelError, match=r"'tensorrt' is unknown.*onnxruntime, openvino"):
        load(tiny_path, engine="tensorrt")


def test_providers_belong_to_onnxruntime(tiny_path):
    with pytest.raises(ModelError, match="providers belong to engine 'onnxruntime'"):
        load(tiny_path, engine="openvino", providers=["CPUExecutionProvider"])
