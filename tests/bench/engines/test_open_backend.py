"""Loading backends, and backends that cannot be loaded."""

from types import SimpleNamespace

import numpy as np
import pytest

from footprints_edge_bench.engines import open_backend as opening
from footprints_edge_bench.engines.backend import (
    Backend,
    BackendError,
    BackendSetting,
    LoadedBackend,
)
from footprints_edge_bench.engines.open_backend import open_backend
from footprints_edge_bench.model_files.model_cache import ModelCache


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cache")
    return ModelCache(folder, folder / "no.pt")


def test_a_package_that_is_missing_is_named(files, monkeypatch):
    def missing(*_):
        raise ModuleNotFoundError("No module named 'fast_engine'", name="fast_engine")

    monkeypatch.setattr(opening, "import_module", lambda _: SimpleNamespace(open_with=missing))
    row = Backend("edge", (256, 448), "ncnn", "fp32")
    with pytest.raises(BackendError, match=r"fast_engine.*peers"):
        open_backend(row, BackendSetting(files, 1))


def test_maps_that_are_no_numbers_are_refused(files, monkeypatch):
    maps = np.full((1, 4, 256, 448), np.nan, np.float32)

    def broken(*_):
        return LoadedBackend(lambda _: maps, "float32", None)

    monkeypatch.setattr(opening, "import_module", lambda _: SimpleNamespace(open_with=broken))
    with pytest.raises(BackendError, match="not finite"):
        open_backend(Backend("edge", (256, 448), "ncnn", "fp32"), BackendSetting(files, 1))
