"""Where one can walk, seen and hidden, and how far away that is: from a single photo, on a CPU.

    import footprints_edge as fp

    model = fp.load()
    prediction = model.predict("street.jpg")

The public names load on first use, so that ``import footprints_edge`` costs next to nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from footprints_edge.errors import (
        FootprintsError,
        GroundPlaneError,
        ImageError,
        IntrinsicsError,
        MissingMapError,
        ModelError,
        NoPathError,
        OffGroundError,
        OutputError,
        OutsideError,
        PlanningError,
        VideoError,
    )
    from footprints_edge.foundation.version import __version__
    from footprints_edge.geometry.camera import Intrinsics
    from footprints_edge.geometry.ground_plane import GroundPlane
    from footprints_edge.model import Model, load
    from footprints_edge.navigation.occupancy_grid import OccupancyGrid
    from footprints_edge.navigation.path_planning import GroundPath
    from footprints_edge.prediction import Prediction
    from footprints_edge.video.smoothing import Tracker

__all__ = [
    "FootprintsError",
    "GroundPath",
    "GroundPlane",
    "GroundPlaneError",
    "ImageError",
    "Intrinsics",
    "IntrinsicsError",
    "MissingMapError",
    "Model",
    "ModelError",
    "NoPathError",
    "OccupancyGrid",
    "OffGroundError",
    "OutputError",
    "OutsideError",
    "PlanningError",
    "Prediction",
    "Tracker",
    "VideoError",
    "__version__",
    "load",
]

_HOME_OF = {
    "FootprintsError": "errors",
    "GroundPath": "navigation.path_planning",
    "GroundPlane": "geometry.ground_plane",
    "GroundPlaneError": "errors",
    "ImageError": "errors",
    "Intrinsics": "geometry.camera",
    "IntrinsicsError": "errors",
    "MissingMapError": "errors",
    "Model": "model",
    "ModelError": "errors",
    "NoPathError": "errors",
    "OffGroundError": "errors",
    "OutputError": "errors",
    "OutsideError": "errors",
    "PlanningError": "errors",
    "Prediction": "prediction",
    "OccupancyGrid": "navigation.occupancy_grid",
    "Tracker": "video.smoothing",
    "VideoError": "errors",
    "__version__": "foundation.version",
    "load": "model",
}


def __getattr__(name: str) -> object:
    """Imports the public name's module on first use (PEP 562)."""
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(f"{__name__}.{_HOME_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
