"""Loading contenders. To add an engine, add its file, its row in ``ENGINES`` and its precisions."""

from collections.abc import Callable
from importlib import import_module

import numpy as np

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.types import Rgb
from footprints_edge.model_files.metadata import OUTPUTS
from footprints_edge_bench.engines.backend import (
    Backend,
    BackendSetting,
    EngineError,
    LoadedBackend,
)
from footprints_edge_bench.model_files.model_cache import outputs_of

ENGINES = {
    "onnxruntime": (
        *("int8", "int8-masks", "int8-depths", "int8-scale2", "int8-scale4", "int8-stock"),
        *("fp32", "fp32-masks", "fp32-depths", "fp32-scale2", "fp32-scale4", "fp32-stock"),
    ),
    "torch": ("fp32",),
    "openvino": ("fp32", "bf16", "int8", "int8-nncf"),
    "ncnn": ("fp32",),
    "litert": ("fp32",),
}
"""Engines and the precisions that they are asked for. ``-stock`` files are without our rewrites of
the graph, which suit onnxruntime; ``-masks``, ``-depths`` and ``-scale`` files compute only that.
OpenVINO's float rows start from stock files. Its ``int8`` is the very file that onnxruntime runs,
``int8-nncf`` the stock float file quantized by OpenVINO's own tool on the same pictures."""


def open_backend(backend: Backend, setting: BackendSetting) -> LoadedBackend:
    """Loads a contender and runs it once.

    Raises:
        EngineError: it cannot run; the message says why.
    """
    if backend.precision not in ENGINES.get(backend.engine, ()):
        raise EngineError(
            f"{backend.engine} {backend.precision} is not a row; there are "
            + ", ".join(f"{name} {kind}" for name, kinds in ENGINES.items() for kind in kinds)
        )
    module = import_module(f"footprints_edge_bench.engines.with_{backend.engine}")
    open_with: Callable[[Backend, BackendSetting], LoadedBackend] = module.open_with
    try:
        running = open_with(backend, setting)
        maps = running.run(np.zeros((1, *backend.size, 3), np.uint8))
    except FootprintsError as error:
        raise EngineError(str(error)) from error
    except ModuleNotFoundError as error:
        raise EngineError(
            f"needs the package {error.name}; install it with: "
            "pip install 'footprints-edge[bench,peers]'"
        ) from error
    except Exception as error:  # engines share no base class
        first = next(iter(str(error).splitlines()), "")
        raise EngineError(f"{type(error).__name__}: {first}") from error
    channels = len(OUTPUTS[outputs_of(backend.precision)])
    if maps.shape != (1, channels, *backend.size) or not np.isfinite(maps).all():
        raise EngineError(f"its maps {maps.shape} are not finite (1, {channels}, H, W)")
    return running


def as_frame(running: LoadedBackend, image: Rgb) -> Callable[[], object]:
    """What is timed: one frame of a contender."""
    return lambda: running.run(image)
