"""onnxruntime with each kind of spinning."""

import numpy as np
import pytest

from footprints_edge.model import load
from footprints_edge_bench.engines.backend import (
    Backend,
    BackendSetting,
    Spinning,
)
from footprints_edge_bench.engines.open_backend import open_backend
from footprints_edge_bench.latency.comparison_photos import synthetic_images
from footprints_edge_bench.model_files.model_cache import ModelCache


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cache")
    return ModelCache(folder, folder / "no.pt")


@pytest.mark.parametrize("spinning", Spinning)
def test_the_way_of_waiting_changes_no_map(green_is_ground, files, spinning):
    row = Backend(str(green_is_ground), (32, 64), "onnxruntime", "fp32")
    running = open_backend(row, BackendSetting(files, 1, spinning))
    image = synthetic_images((32, 64))[0]
    np.testing.assert_array_equal(running.run(image), load(green_is_ground).engine.run(image))
