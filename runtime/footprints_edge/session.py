"""Running a model file. The only module that knows onnxruntime."""

import hashlib
from collections.abc import Sequence
from pathlib import Path

import onnxruntime as ort

from footprints_edge.arrays import Floats, Rgb, Size
from footprints_edge.cores import usable_cores
from footprints_edge.errors import ModelError

_CPU = "CPUExecutionProvider"
_MOST_THREADS = 256

_FOREIGN = {
    b"version https://git-lfs": "it is a Git LFS pointer, not the model; fetch it: git lfs pull",
    b"<": "it is a web page or XML, not a model; download the file itself",
    b"PK\x03\x04": "it looks like a PyTorch checkpoint; make a model of it with: "
    "fp-export convert CHECKPOINT -o OUT.onnx --arch edge",
}


class Session:
    """A model file, loaded. `run` keeps no state: one session may serve many threads.

    Attributes:
        path: The file.
        sha256: SHA-256 of the file's bytes, the very ones that run.
        props: The file's `metadata_props`.
        input_size: (H, W) that the file is fixed to, None where it takes any multiples of 32.
        threads: Threads that one `run` uses.
        providers: onnxruntime's execution providers in use.
    """

    def __init__(
        self, path: Path, *, threads: int | None = None, providers: Sequence[str] | None = None
    ) -> None:
        """Loads a model file.

        Args:
            path: An ONNX file of the footprints-edge contract.
            threads: Threads for one `run`; None means all cores that this process may use.
            providers: onnxruntime execution providers in order of preference; None means CPU.

        Raises:
            ModelError: If the file is missing, damaged or foreign, a provider is not available,
                or the number of threads is not positive.
        """
        if threads is not None and not 1 <= threads <= _MOST_THREADS:
            raise ModelError(f"threads is {threads}; give 1 to {_MOST_THREADS}, or leave it out")
        data = _read(path)
        self.path = path
        self.sha256 = hashlib.sha256(data).hexdigest()
        self.threads = threads or usable_cores()
        if isinstance(providers, str):
            providers = [providers]
        wanted = _checked_providers([_CPU] if providers is None else list(providers))
        options = _options(self.threads)
        try:
            self._session = ort.InferenceSession(data, options, providers=wanted)
        except Exception as error:  # onnxruntime's exceptions share no base class
            raise ModelError(
                f"{path} cannot be loaded ({len(data)} bytes, sha256 {self.sha256}): it is "
                "damaged, no ONNX model, or made for a newer onnxruntime than "
                f"{ort.__version__}; fetch or convert it again. onnxruntime says: {error}"
            ) from error
        self.providers = tuple(self._session.get_providers())
        if self.providers[0] != wanted[0]:  # onnxruntime falls back to the CPU with a mere log line
            raise ModelError(
                f"provider {wanted[0]} is installed but does not start on this machine; "
                f"check its driver, or choose another of {', '.join(available_providers())}"
            )
        self.input_size = self._checked_input_size()
        self.props: dict[str, str] = dict(self._session.get_modelmeta().custom_metadata_map)

    def run(self, image: Rgb) -> Floats:
        """One forward pass.

        Args:
            image: uint8 (1, H, W, 3), red, green, blue; H and W multiples of 32.

        Returns:
            float32 (1, 4, H, W): probabilities of visible ground and of ground, then the sigmoid
            disparities of what is seen and of the ground (the paper's S, S*, D and D*).

        Raises:
            ModelError: If the pass fails, for example for lack of memory.
        """
        try:
            maps: Floats = self._session.run(["maps"], {"image": image})[0]
        except Exception as error:
            raise ModelError(f"{self.path} failed on an input of {image.shape}: {error}") from error
        return maps

    def _checked_input_size(self) -> Size | None:
        """The fixed (H, W), or None; refuses graphs with another input or output."""
        inputs, outputs = self._session.get_inputs(), self._session.get_outputs()
        found = [(node.name, node.type, node.shape) for node in (*inputs, *outputs)]
        match found:
            case [
                ("image", "tensor(uint8)", [1, height, width, 3]),
                ("maps", "tensor(float)", [_, _, _, _]),
            ] if found[1][2][1] in (4, None) or isinstance(found[1][2][1], str):
                pass
            case _:
                raise ModelError(
                    f"{self.path} is an ONNX model with {_signature(found)}; expected image uint8 "
                    "[1, H, W, 3] in and maps float32 [1, 4, H, W] out; make one with: "
                    "fp-export convert CHECKPOINT -o OUT.onnx --arch edge"
                )
        if isinstance(height, int) and isinstance(width, int):
            return height, width
        return None


def available_providers() -> list[str]:
    """Names of the execution providers that the installed onnxruntime has."""
    return list(ort.get_available_providers())


def runtime() -> str:
    """Name and version of what runs the models."""
    return f"onnxruntime {ort.__version__}"


def _read(path: Path) -> bytes:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ModelError(f"model file {path} cannot be read: {error.strerror or error}") from error
    for start, reason in _FOREIGN.items():
        if data.startswith(start):
            raise ModelError(f"{path} is no ONNX model ({len(data)} bytes): {reason}")
    return data


def _checked_providers(wanted: list[str]) -> list[str]:
    available = available_providers()
    unknown = [provider for provider in wanted if provider not in available]
    if unknown or not wanted:
        raise ModelError(
            f"provider {', '.join(unknown) or '(none given)'} is not available here; "
            f"choose from {', '.join(available)}"
        )
    return wanted


def _options(threads: int) -> ort.SessionOptions:
    options = ort.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.execution_mode = ort.ExecutionMode.ORT_SEQUENTIAL
    options.log_severity_level = 4  # errors arrive as exceptions; do not print them as well
    # Between two calls the cores belong to the program around us, not to waiting worker threads.
    options.add_session_config_entry("session.force_spinning_stop", "1")
    return options


def _signature(nodes: list[tuple[str, str, list[object]]]) -> str:
    return ", ".join(f"{name} {kind} {shape}" for name, kind, shape in nodes)
