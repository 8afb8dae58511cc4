"""Find walkable ground, seen and hidden, and its distance in metres: from one photo, on a CPU.

    import footprints_edge as fp

    model = fp.load()
    prediction = model.predict("street.jpg")

The public names load on first use, so ``import footprints_edge`` is cheap.
"""

import os

TYPE_CHECKING = False  # type checkers take it for True; `typing` would be most of this import
if TYPE_CHECKING:
    from footprints_edge.errors import BagError as BagError
    from footprints_edge.errors import CameraPoseError as CameraPoseError
    from footprints_edge.errors import FootprintsError as FootprintsError
    from footprints_edge.errors import GroundPlaneError as GroundPlaneError
    from footprints_edge.errors import ImageError as ImageError
    from footprints_edge.errors import IntrinsicsError as IntrinsicsError
    from footprints_edge.errors import MissingMapError as MissingMapError
    from footprints_edge.errors import ModelError as ModelError
    from footprints_edge.errors import NoPathError as NoPathError
    from footprints_edge.errors import OffGroundError as OffGroundError
    from footprints_edge.errors import OutputError as OutputError
    from footprints_edge.errors import OutsideError as OutsideError
    from footprints_edge.errors import PlanningError as PlanningError
    from footprints_edge.errors import VideoError as VideoError
    from footprints_edge.foundation.version import __version__ as __version__
    from footprints_edge.geometry.camera import Intrinsics as Intrinsics
    from footprints_edge.geometry.camera_pose import CameraPose as CameraPose
    from footprints_edge.geometry.ground_plane import GroundPlane as GroundPlane
    from footprints_edge.inputs.calibration import Calibration as Calibration
    from footprints_edge.model import Model as Model
    from footprints_edge.model import load as load
    from footprints_edge.navigation.occupancy_grid import OccupancyGrid as OccupancyGrid
    from footprints_edge.navigation.path_planning import GroundPath as GroundPath
    from footprints_edge.navigation.range_scan import RangeScan as RangeScan
    from footprints_edge.prediction import Prediction as Prediction
    from footprints_edge.video.smoothing import Tracker as Tracker

# onnxruntime reports to its maker and keeps a device id in the home folder unless this is set
# before it is imported. Whoever sets it to 0 has chosen.
if not os.environ.get("ORT_DISABLE_TELEMETRY"):
    os.environ["ORT_DISABLE_TELEMETRY"] = "1"

_PUBLIC = {
    "errors": (
        "BagError",
        "CameraPoseError",
        "FootprintsError",
        "GroundPlaneError",
        "ImageError",
        "IntrinsicsError",
        "MissingMapError",
        "ModelError",
        "NoPathError",
        "OffGroundError",
        "OutputError",
        "OutsideError",
        "PlanningError",
        "VideoError",
    ),
    "foundation.version": ("__version__",),
    "geometry.camera": ("Intrinsics",),
    "geometry.camera_pose": ("CameraPose",),
    "geometry.ground_plane": ("GroundPlane",),
    "inputs.calibration": ("Calibration",),
    "model": ("Model", "load"),
    "navigation.occupancy_grid": ("OccupancyGrid",),
    "navigation.path_planning": ("GroundPath",),
    "navigation.range_scan": ("RangeScan",),
    "prediction": ("Prediction",),
    "video.smoothing": ("Tracker",),
}
_HOME_OF = {name: module for module, names in _PUBLIC.items() for name in names}

__all__ = sorted(_HOME_OF)  # noqa: PLE0605 - built from the table above


def __getattr__(name: str) -> object:
    """Imports the public name's module on first use (PEP 562)."""
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    value: object = getattr(import_module(f"{__name__}.{_HOME_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
