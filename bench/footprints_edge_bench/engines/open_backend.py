"""Loads backends. To add an engine, add its file and its precisions in ``ENGINES``."""

from collections.abc import Callable
from importlib import import_module

import numpy as np

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.install_hint import install_hint
from footprints_edge.foundation.types import Rgb
from footprints_edge.model_files.metadata import OUTPUTS
from footprints_edge_bench.engines.backend import (
    Backend,
    BackendError,
    BackendSetting,
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
"""Engines and the precisions that they are measured at.

``-stock`` files lack our graph passes, which suit onnxruntime. ``-masks``, ``-depths`` and
``-scale`` files compute only that part. The float rows of OpenVINO start from stock files. Its
``int8`` row is the same file that onnxruntime runs, and ``int8-nncf`` is the stock float32 file
quantized by OpenVINO's own tool on the same images."""


def open_backend(backend: Backend, setting: BackendSetting) -> LoadedBackend:
    """Loads a backend and runs it once.

    Raises:
        BackendError: the backend cannot run; the message says why.
    """
    if backend.precision not in ENGINES.get(backend.engine, ()):
        raise BackendError(
            f"{backend.engine} {backend.precision} is not a row; choose from "
            + ", ".join(f"{name} {kind}" for name, kinds in ENGINES.items() for kind in kinds)
        )
    module = import_module(f"footprints_edge_bench.engines.with_{backend.engine}")
    open_with: Callable[[Backend, BackendSetting], LoadedBackend] = module.open_with
    try:
        loaded = open_with(backend, setting)
        maps = loaded.run(np.zeros((1, *backend.size, 3), np.uint8))
    except FootprintsError as error:
        raise BackendError(str(error)) from error
    except ModuleNotFoundError as error:
        raise BackendError(
            f"needs the package {error.name}; {install_hint('bench,peers')}"
        ) from error
    except Exception as error:  # engines share no base class
        first = next(iter(str(error).splitlines()), "")
        raise BackendError(f"{type(error).__name__}: {first}") from error
    channels = len(OUTPUTS[outputs_of(backend.precision)])
    if maps.shape != (1, channels, *backend.size) or not np.isfinite(maps).all():
        raise BackendError(
            f"its maps have shape {maps.shape} or are not finite; (1, {channels}, H, W) is expected"
        )
    return loaded


def as_frame(loaded: LoadedBackend, image: Rgb) -> Callable[[], object]:
    """One frame of a backend, as it is timed."""
    return lambda: loaded.run(image)
