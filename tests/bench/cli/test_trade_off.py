"""`fp-bench trade-off` on hand-drawn ground, with two models that see what they are shown."""

import json
import shutil

import numpy as np
import pytest
from PIL import Image

from footprints_edge_bench.accuracy.benchmark import open_benchmark
from footprints_edge_bench.engines.backend import BackendSetting
from footprints_edge_bench.ground_truth.datasets import ReadingOptions, Subset
from footprints_edge_bench.latency.backends import LatencyError
from footprints_edge_bench.latency.machine import machine
from footprints_edge_bench.latency.trade_off import difference, trade_off
from footprints_edge_bench.model_files.model_cache import ModelCache

SIZE = (32, 64)


@pytest.fixture
def drawn(tmp_path):
    """A photo of each kind: ground below row 16, on it a thing of 8 x 8 pixels, half of it seen."""
    folder = tmp_path / "drawn"
    (folder / "images").mkdir(parents=True)
    photos = []
    for kind in ("street", "indoor"):
        red = np.zeros((*SIZE, 3), np.uint8)
        red[16:, :, 0] = 250
        red[20:28, 8:12] = 0  # not ground, rightly; on a street nowhere else
        if kind == "indoor":
            red[20:28, 12:16] = 0
        Image.fromarray(red).save(folder / "images" / f"{kind}.png")
        photos.append(
            {
                "name": f"{kind}.png",
                "kind": kind,
                "size_wh": [SIZE[1], SIZE[0]],
                "ground": [[[0, 16], [64, 16], [64, 32], [0, 32]]],
                "footprints": [[[8, 20], [16, 20], [16, 28], [8, 28]]],
            }
        )
    (folder / "truth.json").write_text(json.dumps(photos))
    return folder


def test_models_have_their_accuracy_their_time_and_a_plot(
    fp_bench, green_is_ground, drawn, tmp_path
):
    twin = shutil.copy(green_is_ground, tmp_path / "twin.onnx")
    plot = tmp_path / "plots" / "plot.png"
    done = fp_bench(
        *("trade-off", drawn, "--model", green_is_ground, "--model", twin),
        *("-o", plot, "--trials", 2, "--threads", 1),
    )
    assert done.exit_code == 0, done.output
    heading, _, *rows = [line.split(" | ") for line in done.stdout.splitlines()[:4]]
    assert heading[5:9] == [
        *("drawn-indoor: freespace IoU", "drawn-indoor: footprint IoU"),
        *("drawn-street: freespace IoU", "drawn-street: footprint IoU |"),
    ]
    ground = 16 * 64 - 64
    mean = (1 + 1 + ground / (ground + 32) + 0.5) / 4
    for row in rows:
        assert row[0] == "| green, fp32"
        assert row[3:6] == [f"{mean:.3f}", "+0.000 to +0.000", "1.000"]
        assert row[8] == "0.500 |"
    assert "images: 1 of drawn-indoor, 1 of drawn-street" in done.stdout
    assert Image.open(plot).size[0] > 600


def test_ground_truth_of_visible_ground_alone_is_not_enough(green_is_ground, tmp_path):
    for part in ("images", "labels"):
        (tmp_path / "photos" / part).mkdir(parents=True)
        Image.new("L", SIZE[::-1], 3).save(tmp_path / "photos" / part / "a.png")
    models, reading = [str(green_is_ground)], ReadingOptions(walkable=(3,))
    benchmark = open_benchmark([tmp_path / "photos"], Subset(), models, reading=reading)
    setting = BackendSetting(ModelCache(tmp_path), threads=1)
    with pytest.raises(LatencyError, match="photos/a has no ground truth of hidden ground"):
        trade_off(benchmark, setting, machine(), trials=2)


def test_the_interval_is_of_the_same_images():
    drawing = np.random.default_rng(0)
    first = {"a": drawing.random((30, 2)), "b": drawing.random((10, 2))}
    better = {name: ious + 0.01 for name, ious in first.items()}
    assert difference(better, first) == pytest.approx((0.01, 0.01))
    low, high = difference({name: drawing.random(s.shape) for name, s in first.items()}, first)
    assert low < high
