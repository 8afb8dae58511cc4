"""LiteRT gives the maps of PyTorch, or says what it needs."""

import importlib.util

import numpy as np
import pytest

from footprints_edge_bench.engines.backend import Backend, BackendError, BackendSetting
from footprints_edge_bench.engines.open_backend import open_backend
from footprints_edge_bench.latency.comparison_photos import synthetic_images
from footprints_edge_bench.model_files.model_cache import ModelCache

pytest.importorskip("ai_edge_litert", reason="ai-edge-litert of the extra peers is not installed")
HAS_CONVERTER = importlib.util.find_spec("litert_torch") is not None


@pytest.mark.skipif(not HAS_CONVERTER, reason="litert-torch is not installed, no extra brings it")
def test_its_maps_are_those_of_pytorch(tmp_path):
    setting = BackendSetting(ModelCache(tmp_path), 1)
    image = synthetic_images((64, 96))[0]
    loaded, torch = (
        open_backend(Backend("reference", (64, 96), engine, "fp32"), setting)
        for engine in ("litert", "torch")
    )
    np.testing.assert_allclose(loaded.run(image), torch.run(image), atol=1e-3)
    assert loaded.precision.startswith("float32 (")


@pytest.mark.skipif(HAS_CONVERTER, reason="litert-torch is installed")
def test_without_its_converter_it_says_what_to_install(tmp_path):
    backend = Backend("reference", (64, 96), "litert", "fp32")
    with pytest.raises(BackendError, match="pip install litert-torch"):
        open_backend(backend, BackendSetting(ModelCache(tmp_path), 1))
