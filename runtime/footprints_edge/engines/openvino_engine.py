"""Running a model file with OpenVINO, the extra `openvino`. The only module that knows it."""

import hashlib
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from footprints_edge.engines.engine import checked_input_size, checked_threads, read_model_file
from footprints_edge.errors import ModelError
from footprints_edge.foundation.types import Floats, Rgb, Size

_MOST_SIZES = 8
"""So many networks of different input sizes are kept; each was compiled for its own."""

_TYPES = {"u8": "tensor(uint8)", "f32": "tensor(float)"}


class OpenVinoEngine:
    """A model file in OpenVINO, on the CPU; see `engine.Engine`.

    A network of free input size is compiled anew for every size that it meets, which takes a
    second or so at its first picture.
    """

    def __init__(self, path: Path, *, threads: int | None = None) -> None:
        """Loads a model file.

        Args:
            path: An ONNX file of the footprints-edge contract.
            threads: Threads for one `run`; None means all cores that this process may use.

        Raises:
            ModelError: If the package openvino is missing, the file is missing, damaged or
                foreign, or the number of threads is not positive.
        """
        try:
            import openvino
        except ModuleNotFoundError as error:
            raise ModelError(
                "engine 'openvino' needs the package openvino; install it with: "
                "pip install 'footprints-edge[openvino]'"
            ) from error
        self.threads = checked_threads(threads)
        data = read_model_file(path)
        self.path = path
        self.sha256 = hashlib.sha256(data).hexdigest()
        self.providers: tuple[str, ...] = ("CPU",)
        self.runtime = f"openvino {openvino.__version__.partition('-')[0]}"
        self._core = openvino.Core()
        try:
            self._model = self._core.read_model(data)
        except Exception as error:
            raise ModelError(
                f"{path} cannot be loaded ({len(data)} bytes, sha256 {self.sha256}): it is "
                f"damaged, no ONNX model, or too new for {self.runtime}; fetch or "
                f"convert it again. OpenVINO says: {error}"
            ) from error
        self.input_size = checked_input_size(
            path, [_described(node) for node in (*self._model.inputs, *self._model.outputs)]
        )
        self.props = _metadata(self._model)
        self._networks: dict[Size, Any] = {}
        self._lock = Lock()

    def run(self, image: Rgb) -> Floats:
        """One forward pass; see `engine.Engine.run`."""
        size = (image.shape[1], image.shape[2])
        if self.input_size not in (None, size):  # OpenVINO would take it
            raise ModelError(
                f"{self.path} failed on an input of {image.shape}: it is fixed to {self.input_size}"
            )
        try:
            request = self._network(size).create_infer_request()
            request.infer([np.ascontiguousarray(image)])
            maps: Floats = np.array(request.get_output_tensor(0).data)
        except Exception as error:
            raise ModelError(f"{self.path} failed on an input of {image.shape}: {error}") from error
        return maps

    def _network(self, size: Size) -> Any:  # noqa: ANN401
        """The network compiled for an input of (h, w)."""
        with self._lock:
            if size not in self._networks:
                while len(self._networks) >= _MOST_SIZES:
                    del self._networks[next(iter(self._networks))]
                model = self._model.clone()
                model.reshape([1, *size, 3])
                options = {
                    "INFERENCE_PRECISION_HINT": "f32",  # else bfloat16 where the CPU has it
                    "INFERENCE_NUM_THREADS": self.threads,
                    "NUM_STREAMS": 1,
                    "PERFORMANCE_HINT": "LATENCY",
                }
                self._networks[size] = self._core.compile_model(model, "CPU", options)
            return self._networks[size]


def _metadata(model: Any) -> dict[str, str]:  # noqa: ANN401
    """The file's `metadata_props`, which OpenVINO files under `framework`."""
    info = model.get_rt_info()
    if "framework" not in info:
        return {}
    facts = getattr(info["framework"], "value", info["framework"])
    return {key: str(getattr(value, "value", value)) for key, value in facts.items()}


def _described(node: Any) -> tuple[str, str, list[object]]:  # noqa: ANN401
    """Name, type and shape in onnxruntime's words; a side that is free is None."""
    kind = node.element_type.get_type_name()
    shape = [side.get_length() if side.is_static else None for side in node.partial_shape]
    return node.any_name, _TYPES.get(kind, kind), shape
