"""OpenVINO, on our int8 file, on the stock float32 file, or on that file quantized by NNCF.

On processors with bfloat16, OpenVINO computes float networks in it unless the precision is forced.
"""

import contextlib
import io
import logging
from pathlib import Path
from typing import Any

import numpy as np

from footprints_edge.foundation.openvino import import_openvino
from footprints_edge.foundation.types import Floats, Rgb
from footprints_edge_bench.engines.backend import (
    Backend,
    BackendSetting,
    LoadedBackend,
    describe_precisions,
)
from footprints_edge_bench.foundation.fingerprint import sha256_of_file

_HINTS = {"fp32": "f32", "bf16": "bf16", "int8": "f32", "int8-nncf": "f32"}
_FILES = {"fp32": "fp32-stock", "bf16": "fp32-stock", "int8": "int8"}
_PRECISIONS = {"u8": "int8", "i8": "int8", "f32": "float32", "bf16": "bfloat16", "f16": "float16"}


def open_with(backend: Backend, setting: BackendSetting) -> LoadedBackend:
    """Loads a backend; its precision is that of the graph that OpenVINO compiled."""
    openvino = import_openvino()

    core = openvino.Core()
    if backend.precision == "int8-nncf":
        path = _quantized(backend, setting)
        file_bytes = path.stat().st_size + path.with_suffix(".bin").stat().st_size
    else:
        precision = _FILES[backend.precision]
        path = setting.cache.onnx(backend.network, backend.size, precision)
        file_bytes = path.stat().st_size
    model = core.read_model(path)
    model.reshape([1, *backend.size, 3])
    compiled = core.compile_model(
        model,
        "CPU",
        {
            "INFERENCE_PRECISION_HINT": _HINTS[backend.precision],
            "INFERENCE_NUM_THREADS": setting.threads,
            "NUM_STREAMS": 1,
            "PERFORMANCE_HINT": "LATENCY",
        },
    )
    request = compiled.create_infer_request()

    def run(image: Rgb) -> Floats:
        request.infer([image], share_inputs=True)
        maps: Floats = np.array(request.get_output_tensor(0).data)
        return maps

    return LoadedBackend(run, describe_precisions(_convolutions(compiled)), file_bytes)


def _convolutions(compiled: Any) -> dict[str, int]:  # noqa: ANN401
    """Number of convolutions of a compiled model by precision."""
    kinds: dict[str, int] = {}
    for node in compiled.get_runtime_model().get_ordered_ops():
        facts = node.get_rt_info()
        if str(_plain(facts, "layerType")) in ("Convolution", "GroupConvolution"):
            precision = str(_plain(facts, "runtimePrecision")).lower()
            kind = _PRECISIONS.get(precision, precision)
            kinds[kind] = kinds.get(kind, 0) + 1
    return kinds


def _plain(facts: Any, key: str) -> object:  # noqa: ANN401
    value = facts[key]
    return getattr(value, "value", value)


def _quantized(backend: Backend, setting: BackendSetting) -> Path:
    """The float32 file quantized by NNCF, on the calibration images of our own int8."""
    import nncf

    openvino = import_openvino()

    source = setting.cache.onnx(backend.network, backend.size, "fp32-stock")

    def make(folder: Path) -> None:
        logging.getLogger("nncf").setLevel(logging.ERROR)
        model = openvino.Core().read_model(source)
        model.reshape([1, *backend.size, 3])
        images = setting.cache.calibration_images(backend.size)
        with contextlib.redirect_stdout(io.StringIO()):  # NNCF draws progress bars there
            quantized = nncf.quantize(model, nncf.Dataset(images), subset_size=len(images))
        openvino.save_model(quantized, folder / "model.xml", compress_to_fp16=False)

    made = setting.cache.kept(
        f"{backend.network}-{backend.size[0]}x{backend.size[1]}-nncf",
        {"source": sha256_of_file(source), "nncf": nncf.__version__},
        make,
    )
    return made / "model.xml"
