"""ncnn gives the maps of PyTorch."""

import numpy as np
import pytest

from footprints_edge_bench.engines.backend import Backend, BackendSetting
from footprints_edge_bench.engines.open_backend import open_backend
from footprints_edge_bench.latency.comparison_photos import synthetic_images
from footprints_edge_bench.model_files.model_cache import ModelCache

for package in ("ncnn", "pnnx"):
    pytest.importorskip(package, reason=f"{package} of the extra peers is not installed")


def test_its_maps_are_those_of_pytorch(tmp_path):
    setting = BackendSetting(ModelCache(tmp_path), 1)
    image = synthetic_images((64, 96))[0]
    loaded, torch = (
        open_backend(Backend("reference", (64, 96), engine, "fp32"), setting)
        for engine in ("ncnn", "torch")
    )
    np.testing.assert_allclose(loaded.run(image), torch.run(image), atol=1e-3)
    assert loaded.precision.startswith("float32 (")
    assert loaded.file_bytes > 1e6
