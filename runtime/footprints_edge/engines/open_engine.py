"""Choosing the engine that runs a model file. To add one, write its file and name it here."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from footprints_edge.engines.engine import Engine
from footprints_edge.engines.onnxruntime_engine import OnnxRuntimeEngine
from footprints_edge.errors import ModelError


def open_engine(
    path: Path,
    engine: str,
    *,
    threads: int | None = None,
    providers: Sequence[str | tuple[str, Mapping[str, Any]]] | None = None,
    session_options: Mapping[str, str] | None = None,
) -> Engine:
    """Loads a model file into an engine; the arguments are those of `model.load`.

    Raises:
        ModelError: If the engine is unknown or missing, or cannot run the file.
    """
    if engine == "onnxruntime":
        return OnnxRuntimeEngine(
            path, threads=threads, providers=providers, session_options=session_options
        )
    if providers is not None:
        raise ModelError(
            f"providers belong to engine 'onnxruntime'; leave them out for engine {engine!r}"
        )
    if engine == "openvino":
        from footprints_edge.engines.openvino_engine import OpenVinoEngine

        return OpenVinoEngine(path, threads=threads, session_options=session_options)
    if engine.startswith("onnxruntime-ep-"):
        return OnnxRuntimeEngine(
            path, threads=threads, plugin=engine, session_options=session_options
        )
    raise ModelError(
        f"engine {engine!r} is unknown; choose onnxruntime, openvino, or a package that plugs into "
        "onnxruntime: onnxruntime-ep-..."
    )
