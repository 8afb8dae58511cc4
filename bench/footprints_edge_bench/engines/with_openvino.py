"""OpenVINO, on our int8 file, on the float file as exported, or on what its own NNCF makes of it.

On processors with bfloat16 OpenVINO computes float networks in it unless it is told not to.
"""

import contextlib
import io
import logging
from pathlib import Path
from typing import Any

import numpy as np

from footprints_edge.foundation.types import Floats, Rgb
from footprints_edge_bench.engines.backend import Backend, BackendSetting, LoadedBackend, counted

_HINTS = {"fp32": "f32", "bf16": "bf16", "int8": "f32", "int8-nncf": "f32"}
_FILES = {"fp32": "fp32-stock", "bf16": "fp32-stock", "int8": "int8"}
_PRECISIONS = {"u8": "int8", "i8": "int8", "f32": "float32", "bf16": "bfloat16", "f16": "float16"}


def open_with(backend: Backend, setting: BackendSetting) -> LoadedBackend:
    """Loads a contender; its precisions are those of the graph that OpenVINO made."""
    import openvino

    core = openvino.Core()
    if backend.precision == "int8-nncf":
        path = _quantized(backend, setting)
        file_bytes = path.stat().st_size + path.with_suffix(".bin").stat().st_size
    else:
        precision = _FILES[backend.precision]
        path = setting.files.onnx(backend.network, backend.size, precision)
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

    return LoadedBackend(run, counted(_convolutions(compiled)), file_bytes)


def _convolutions(compiled: Any) -> dict[str, int]:  # noqa: ANN401
    """How many convolutions of a compiled model compute in which precision."""
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
    """The float file, quantized by NNCF on the pictures that our own int8 is calibrated on."""
    import nncf
    import openvino

    source = setting.files.onnx(backend.network, backend.size, "fp32-stock")

    def make(folder: Path) -> None:
        logging.getLogger("nncf").setLevel(logging.ERROR)
        model = openvino.Core().read_model(source)
        model.reshape([1, *backend.size, 3])
        images = setting.files.calibration_images(backend.size)
        with contextlib.redirect_stdout(io.StringIO()):  # it draws progress bars there
            quantized = nncf.quantize(
                model, nncf.EvaluationDataset(images), subset_size=len(images)
            )
        openvino.save_model(quantized, folder / "model.xml", compress_to_fp16=False)

    made = setting.files.kept(
        f"{backend.network}-{backend.size[0]}x{backend.size[1]}-nncf",
        {"source": setting.files.sha256(source), "nncf": nncf.__version__},
        make,
    )
    return made / "model.xml"
