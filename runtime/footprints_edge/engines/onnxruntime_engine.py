"""The onnxruntime engine. The only module that imports onnxruntime."""

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from threading import Lock
from typing import Any
from weakref import WeakSet

import onnxruntime as ort

from footprints_edge.engines.engine import checked_input_size, checked_maps, checked_threads
from footprints_edge.engines.optimised_graphs import (
    forget_optimised,
    keep_optimised,
    read_optimised,
    worth_keeping,
)
from footprints_edge.errors import ModelError
from footprints_edge.foundation.types import Floats, Rgb
from footprints_edge.model_files.read import read_model_file

_CPU = "CPUExecutionProvider"


_loaded: "WeakSet[OnnxRuntimeEngine]" = WeakSet()


def _never_end_sessions() -> None:
    """For a forked process, which lacks the threads of the sessions that it inherits.

    It can run them, on one thread; but to end one would be to wait for its threads for ever, and
    Python ends them all when the process ends.
    """
    import ctypes

    for engine in _loaded:
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(engine._session._sess))


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_never_end_sessions)


class OnnxRuntimeEngine:
    """Runs a model file with onnxruntime; see `engine.Engine`."""

    def __init__(
        self,
        path: Path,
        *,
        threads: int | None = None,
        providers: Sequence[str | tuple[str, Mapping[str, Any]]] | None = None,
        plugin: str | None = None,
        session_options: Mapping[str, str] | None = None,
    ) -> None:
        """Loads a model file.

        Args:
            path: An ONNX file of the footprints-edge contract, or one in onnxruntime's format.
            threads: Threads for one `run`; None means all cores that this process may use.
            providers: onnxruntime execution providers in order of preference, alone or with their
                options; None means CPU.
            plugin: Package of a plug-in execution provider, such as `onnxruntime-ep-openvino`,
                instead of `providers`. Nodes that it does not support run on the CPU; `runtime`
                says how many it runs.
            session_options: Configuration entries of the session.

        Raises:
            ModelError: If the file is missing, damaged or breaks the file contract, if a provider
                is not available, or if the number of threads is not positive.
        """
        self.threads = checked_threads(threads)
        file = read_model_file(path)
        self.path, self.sha256, data = path, file.sha256, file.data
        if isinstance(providers, str):
            providers = [providers]
        options = _options(self.threads, session_options or {})
        given: list[dict[str, Any]] = []
        if plugin is None:
            wanted, given = _checked_providers([_CPU] if providers is None else list(providers))
        else:
            wanted = []
            _add_plugin(options, plugin)
        plain = wanted == [_CPU] and not any(given) and not session_options
        try:
            if plain and worth_keeping(data):
                self._session = _session_by_cache(data, self.sha256, options)
            else:
                self._session = ort.InferenceSession(
                    data, options, providers=wanted, provider_options=given or None
                )
        except Exception as error:  # onnxruntime's exceptions share no base class
            raise ModelError(
                f"{path} cannot be loaded ({len(data)} bytes, sha256 {self.sha256}): it is "
                "damaged, not an ONNX model, or made for a newer onnxruntime than "
                f"{ort.__version__}; fetch or convert it again. onnxruntime says: {error}"
            ) from error
        _loaded.add(self)
        self.providers: tuple[str, ...] = tuple(self._session.get_providers())
        if wanted and self.providers[0] != wanted[0]:  # onnxruntime only logs this fallback
            raise ModelError(
                f"provider {wanted[0]} is installed but does not start on this machine; "
                f"check its driver, or choose another of {', '.join(available_providers())}"
            )
        self.runtime = runtime()
        if plugin is not None:
            self.runtime += f", {self._assigned_nodes(plugin)}"
        elif wanted[0] != _CPU:
            self.runtime += f", {wanted[0]}"
        try:
            nodes = [*self._session.get_inputs(), *self._session.get_outputs()]
            found = [(node.name, node.type, node.shape) for node in nodes]
            self.props: dict[str, str] = dict(self._session.get_modelmeta().custom_metadata_map)
        except UnicodeDecodeError as error:
            raise ModelError(f"{path} is damaged: a text in it is not UTF-8") from error
        self.input_size = checked_input_size(path, found)

    def run(self, image: Rgb) -> Floats:
        """One forward pass; see `engine.Engine.run`."""
        try:
            maps: Floats = self._session.run(["maps"], {"image": image})[0]
        except Exception as error:
            raise ModelError(f"{self.path} failed on an input of {image.shape}: {error}") from error
        return checked_maps(self.path, maps, (image.shape[1], image.shape[2]))

    def _assigned_nodes(self, plugin: str) -> str:
        """The number of nodes by provider; rejects a plug-in that runs none."""
        nodes: Counter[str] = Counter()
        for part in self._session.get_provider_graph_assignment_info():
            nodes[part.ep_name] += len(part.get_nodes())
        if not nodes.keys() & set(_plugin_providers(plugin)):
            raise ModelError(
                f"{plugin} supports none of the nodes of {self.path}, so onnxruntime would run "
                "them all on the CPU; choose engine='onnxruntime' for that"
            )
        return ", ".join(f"{name} {count} nodes" for name, count in nodes.most_common())


def _session_by_cache(data: bytes, sha256: str, options: ort.SessionOptions) -> Any:  # noqa: ANN401
    """A session on the CPU, of the graph that an earlier one has optimised if there is one."""
    if (graph := read_optimised(sha256, runtime())) is not None:
        options.graph_optimization_level = ort.GraphOptimizationLevel.ORT_DISABLE_ALL
        try:
            return ort.InferenceSession(graph, options, providers=[_CPU])
        except Exception:  # whatever it is, the model file itself may still be good
            forget_optimised(sha256)
        options.graph_optimization_level = ort.GraphOptimizationLevel.ORT_ENABLE_ALL
    from tempfile import TemporaryDirectory  # as much work to import as a picture's result

    try:
        with TemporaryDirectory(prefix="fp-") as folder:
            path = Path(folder, "optimised.onnx")
            options.optimized_model_filepath = str(path)
            session = ort.InferenceSession(data, options, providers=[_CPU])
            keep_optimised(sha256, runtime(), path.read_bytes())
            return session
    except Exception:  # it may not be able to save it, or to load the model at all
        options.optimized_model_filepath = ""
        return ort.InferenceSession(data, options, providers=[_CPU])


def available_providers() -> list[str]:
    """Names of the execution providers in the installed onnxruntime."""
    return list(ort.get_available_providers())


def runtime() -> str:
    """Name and version of the engine."""
    return f"onnxruntime {ort.__version__}"


def _checked_providers(
    given: list[str | tuple[str, Mapping[str, Any]]],
) -> tuple[list[str], list[dict[str, Any]]]:
    """Names of providers and the options of each."""
    pairs = [(entry, {}) if isinstance(entry, str) else entry for entry in given]
    wanted, available = [str(name) for name, _ in pairs], available_providers()
    unknown = [provider for provider in wanted if provider not in available]
    if unknown or not wanted:
        raise ModelError(
            f"provider {', '.join(unknown) or '(none given)'} is not available here; "
            f"choose from {', '.join(available)}"
        )
    return wanted, [dict(options) for _, options in pairs]


def _add_plugin(options: ort.SessionOptions, plugin: str) -> None:
    """Selects the devices of a plug-in.

    Raises:
        ModelError: If it is not installed, does not load, or offers no device here.
    """
    names = _plugin_providers(plugin)
    devices = [device for device in ort.get_ep_devices() if device.ep_name in names]
    if not devices:
        raise ModelError(
            f"{plugin} is installed but offers no device on this machine: its hardware or driver "
            "is missing; choose another engine"
        )
    options.add_provider_for_devices(devices, {})
    options.add_session_config_entry("session.record_ep_graph_assignment_info", "1")


_registering = Lock()


def _plugin_providers(plugin: str) -> tuple[str, ...]:
    """The names of a plug-in's execution providers; registers it once with onnxruntime."""
    with _registering:  # a cache alone would let two threads do it
        return _registered(plugin)


@cache
def _registered(plugin: str) -> tuple[str, ...]:
    try:
        package = import_module(plugin.replace("-", "_"))
    except ModuleNotFoundError as error:
        raise ModelError(
            f"engine {plugin!r} needs the package {plugin}; install it with: pip install {plugin}"
        ) from error
    try:
        ort.register_execution_provider_library(plugin, package.get_library_path())
        return tuple(package.get_ep_names())
    except Exception as error:
        raise ModelError(
            f"{plugin} cannot be loaded into onnxruntime {ort.__version__}: {error}; "
            "upgrade both, or choose another engine"
        ) from error


def _options(threads: int, entries: Mapping[str, str]) -> ort.SessionOptions:
    options = ort.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.execution_mode = ort.ExecutionMode.ORT_SEQUENTIAL
    options.log_severity_level = 4  # errors arrive as exceptions; do not print them as well
    # Between two calls, waiting worker threads must not occupy the cores.
    options.add_session_config_entry("session.force_spinning_stop", "1")
    for key, value in entries.items():
        try:
            options.add_session_config_entry(key, str(value))
        except Exception as error:
            raise ModelError(
                f"onnxruntime {ort.__version__} refuses the session option {key!r}: {error}"
            ) from error
    return options
