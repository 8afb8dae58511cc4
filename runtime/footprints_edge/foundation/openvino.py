"""The only module that imports OpenVINO, which comes with the extra `openvino`."""

import sys
from typing import Any


def import_openvino() -> Any:  # noqa: ANN401 - it has no types
    """The module `openvino`, which reports nothing to its maker.

    Its import sends an event to Google Analytics and keeps an id in the home folder, unless the
    package `openvino_telemetry` is absent: then it takes a stub of its own.

    Raises:
        ModuleNotFoundError: If it is not installed.
    """
    there = sys.modules.get("openvino_telemetry")
    sys.modules["openvino_telemetry"] = None  # type: ignore[assignment]  # "not installed"
    try:
        import openvino
    finally:
        del sys.modules["openvino_telemetry"]
        if there is not None:
            sys.modules["openvino_telemetry"] = there
    return openvino
