"""The two measurements: IoU in closed form, and timings that are fair."""

import json
import subprocess
import sys
import time

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper
from PIL import Image

import footprints_edge
from footprints_edge.metadata import ModelMetadata
from footprints_edge_bench.against_reference import interleaved_ms
from footprints_edge_bench.visible_ground import score

SIZE = (32, 64)


@pytest.fixture(scope="module")
def green_is_ground(tmp_path_factory):
    """A model fixed to (32, 64) whose probability of visible ground is how green a pixel is."""
    weights = np.zeros((4, 3, 1, 1), np.float32)
    weights[0, 1] = 1 / 255
    graph = helper.make_graph(
        [
            helper.make_node("Cast", ["image"], ["float"], to=TensorProto.FLOAT),
            helper.make_node("Transpose", ["float"], ["planes"], perm=[0, 3, 1, 2]),
            helper.make_node("Conv", ["planes", "weights"], ["maps"]),
        ],
        "green",
        [helper.make_tensor_value_info("image", TensorProto.UINT8, [1, *SIZE, 3])],
        [helper.make_tensor_value_info("maps", TensorProto.FLOAT, [1, 4, *SIZE])],
        [numpy_helper.from_array(weights, "weights")],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=10)
    metadata = ModelMetadata(
        "green", "edge", "fp32", (0.1, 100.0), None, "lanczos", "none", "0" * 64, "tests", "none"
    )
    helper.set_model_props(model, metadata.to_props())
    path = tmp_path_factory.mktemp("models") / "green.onnx"
    onnx.save(model, path)
    return path


def write(folder, name, found, ids):
    """A photo that the model calls ground where `found`, and its labels."""
    for part in ("images", "labels"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    image = np.zeros((*SIZE, 3), np.uint8)
    image[..., 1] = np.where(found, 250, 5)
    Image.fromarray(image).save(folder / "images" / f"{name}.png")
    Image.fromarray(np.broadcast_to(ids, SIZE).astype(np.uint8)).save(
        folder / "labels" / f"{name}.png"
    )


@pytest.fixture
def photos(tmp_path):
    """Two photos whose overlaps are counted by hand below."""
    column = np.arange(SIZE[1]) * np.ones((SIZE[0], 1))
    # Found: columns 0-31. Road 16-39, pavement 40-47, void 48-63 and 0-7, else wall.
    ids = np.full(SIZE, 7)
    ids[:, 16:40], ids[:, 40:48], ids[:, 48:], ids[:, :8] = 3, 4, 11, 11
    write(tmp_path, "a", column < 32, ids)
    write(tmp_path, "b", column < 10, np.where(column < 20, 3, 7))
    return tmp_path


def test_iou_over_the_pixels_of_all_photos(green_is_ground, photos):
    model = footprints_edge.load(green_is_ground, threads=1)
    found = score(model, photos, walkable=[3, 4], void=[11])
    # a: both 16-31; either 8-47. b: both 0-9; either 0-19.
    assert found.iou == pytest.approx((16 + 10) / (40 + 20))
    assert found.photos == 2
    assert (found.model, found.precision) == ("green.onnx", "fp32")


def test_what_is_walkable_and_void_is_the_callers_to_say(green_is_ground, photos):
    model = footprints_edge.load(green_is_ground, threads=1)
    # Without void: a: both 16-31, either 0-39; b as before.
    assert score(model, photos, [3], []).iou == pytest.approx((16 + 10) / (40 + 20))
    # Void walls: a: both 16-31, either 16-47 and the void sides 0-7; b: 10 of 20.
    assert score(model, photos, [3, 4], [7]).iou == pytest.approx((16 + 10) / (8 + 32 + 20))


def test_a_photo_is_judged_at_its_own_size(green_is_ground, tmp_path):
    """Four times the model's size: as many pixels of border, not four times as many counted."""
    (tmp_path / "images").mkdir()
    (tmp_path / "labels").mkdir()
    image, ids = np.zeros((128, 256, 3), np.uint8), np.full((128, 256), 7, np.uint8)
    image[64:, :, 1], ids[64:] = 255, 3
    Image.fromarray(image).save(tmp_path / "images" / "a.png")
    Image.fromarray(ids).save(tmp_path / "labels" / "a.png")
    found = score(footprints_edge.load(green_is_ground, threads=1), tmp_path, [3], [])
    assert found.iou > 0.95


def test_the_command_prints_one_line_a_model(green_is_ground, photos):
    done = subprocess.run(
        [
            *(sys.executable, "-m", "footprints_edge_bench.visible_ground", photos),
            *("--walkable", "3", "4", "--void", "11"),
            *("--model", green_is_ground, green_is_ground),
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(lines) == 2
    assert all(line["iou"] == pytest.approx(26 / 60) for line in lines)


def test_each_variant_runs_as_often_as_the_others():
    calls = []
    times_ms = interleaved_ms(
        {name: lambda name=name: calls.append(name) for name in "abc"}, trials=20
    )
    assert {name: len(times) for name, times in times_ms.items()} == {"a": 20, "b": 20, "c": 20}
    measured = calls[-60:]
    # In turns: after every round of three, each has run once more; and not always in one order.
    rounds = ["".join(measured[i : i + 3]) for i in range(0, 60, 3)]
    assert {"".join(sorted(r)) for r in rounds} == {"abc"}
    assert len(set(rounds)) > 1
    warm_up = calls[:-60]
    assert set(warm_up) == set("abc")


def test_a_slow_neighbour_does_not_slow_the_measurement():
    def busy(seconds):
        end = time.perf_counter() + seconds
        while time.perf_counter() < end:
            pass

    quick = {"quick": lambda: busy(0.002)}
    alone = interleaved_ms(quick, 20)
    beside = interleaved_ms(quick | {"slow": lambda: busy(0.01)}, 20)
    assert min(alone["quick"]) == pytest.approx(2, rel=0.3)
    assert min(beside["quick"]) == pytest.approx(min(alone["quick"]), rel=0.3)
    assert min(beside["slow"]) == pytest.approx(10, rel=0.3)
