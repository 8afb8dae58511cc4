"""The OpenVINO engine (the extra `openvino`)."""

from collections.abc import Mapping
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from footprints_edge.engines.engine import checked_input_size, checked_maps, checked_threads
from footprints_edge.errors import ModelError
from footprints_edge.foundation.install_hint import install_hint
from footprints_edge.foundation.openvino import import_openvino
from footprints_edge.foundation.types import Floats, Rgb, Size
from footprints_edge.model_files.read import read_model_file

_CACHED_SIZES = 8
"""Maximum number of compiled networks to keep, one for each input size."""

_TYPES = {"u8": "tensor(uint8)", "f32": "tensor(float)"}


class OpenVinoEngine:
    """Runs a model file with OpenVINO on the CPU; see `engine.Engine`.

    A network with dynamic input size is compiled for each new size, which adds about a second to
    the first picture of that size.
    """

    def __init__(
        self,
        path: Path,
        *,
        threads: int | None = None,
        session_options: Mapping[str, str] | None = None,
    ) -> None:
        """Loads a model file.

        Args:
            path: An ONNX file of the footprints-edge contract.
            threads: Threads for one `run`; None means all cores that this process may use.
            session_options: Properties of OpenVINO's CPU plugin, such as
                `{"LP_TRANSFORMS_MODE": "NO"}`, which computes int8 files in floats: no sum
                saturates on x86 without VNNI then.

        Raises:
            ModelError: If the package openvino is missing, if the file is missing, damaged or
                breaks the file contract, if OpenVINO knows no such property or value, or if the
                number of threads is not positive.
        """
        try:
            openvino = import_openvino()
        except ModuleNotFoundError as error:
            raise ModelError(
                f"engine 'openvino' needs the package openvino; {install_hint('openvino')}"
            ) from error
        self.threads = checked_threads(threads)
        file = read_model_file(path)
        self.path, self.sha256, data = path, file.sha256, file.data
        self.providers: tuple[str, ...] = ("CPU",)
        self.runtime = f"openvino {openvino.__version__.partition('-')[0]}"
        self._core = openvino.Core()
        self._held = {
            "INFERENCE_PRECISION_HINT": "f32",  # default: bfloat16 if the CPU has it
            "INFERENCE_NUM_THREADS": self.threads,
            "NUM_STREAMS": 1,
            "PERFORMANCE_HINT": "LATENCY",
        }
        options = dict(session_options or {})
        if held := sorted(self._held.keys() & options.keys()):
            raise ModelError(f"the session options {held} are set by the engine; see `threads`")
        try:
            self._core.get_versions("CPU")  # loads the plugin, which then looks at its properties
            self._core.set_property("CPU", options)
        except Exception as error:
            raise ModelError(
                f"{self.runtime} refuses the session options {options}: they "
                f"are properties of its CPU plugin. OpenVINO says: {error}"
            ) from error
        try:
            self._model = self._core.read_model(data)
        except Exception as error:
            raise ModelError(
                f"{path} cannot be loaded ({len(data)} bytes, sha256 {self.sha256}): it is "
                f"damaged, not an ONNX model, or too new for {self.runtime}; fetch or "
                f"convert it again. OpenVINO says: {error}"
            ) from error
        try:
            found = [_described(node) for node in (*self._model.inputs, *self._model.outputs)]
            self.props = _metadata(self._model)
        except (UnicodeDecodeError, RuntimeError) as error:  # RuntimeError: a nameless output
            raise ModelError(f"{path} is damaged: {error}") from error
        self.input_size = checked_input_size(path, found)
        self._networks: dict[Size, Any] = {}
        self._lock = Lock()

    def run(self, image: Rgb) -> Floats:
        """One forward pass; see `engine.Engine.run`."""
        size = (image.shape[1], image.shape[2])
        if self.input_size not in (None, size):  # OpenVINO would accept it
            raise ModelError(
                f"{self.path} failed on an input of {image.shape}: its fixed input size is "
                f"{self.input_size}"
            )
        try:
            request = self._network(size).create_infer_request()
            request.infer([np.ascontiguousarray(image)])
            maps: Floats = np.array(request.get_output_tensor(0).data)
        except Exception as error:
            raise ModelError(f"{self.path} failed on an input of {image.shape}: {error}") from error
        return checked_maps(self.path, maps, size)

    def _network(self, size: Size) -> Any:  # noqa: ANN401
        """The network compiled for an input size (h, w)."""
        with self._lock:
            if size not in self._networks:
                while len(self._networks) >= _CACHED_SIZES:
                    del self._networks[next(iter(self._networks))]
                model = self._model.clone()
                model.reshape([1, *size, 3])
                self._networks[size] = self._core.compile_model(model, "CPU", self._held)
            return self._networks[size]


def _metadata(model: Any) -> dict[str, str]:  # noqa: ANN401
    """The file's `metadata_props`, which OpenVINO stores under `framework`."""
    info = model.get_rt_info()
    if "framework" not in info:
        return {}
    facts = getattr(info["framework"], "value", info["framework"])
    return {key: str(getattr(value, "value", value)) for key, value in facts.items()}


def _described(node: Any) -> tuple[str, str, list[object]]:  # noqa: ANN401
    """Name, type and shape in onnxruntime's terms; a dynamic side is None."""
    kind = node.element_type.get_type_name()
    shape = [side.get_length() if side.is_static else None for side in node.partial_shape]
    return node.any_name, _TYPES.get(kind, kind), shape
