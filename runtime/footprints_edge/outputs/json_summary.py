"""The summary of a prediction, which is the content of the `json` output."""

import math
from contextlib import suppress
from typing import Any

import numpy as np

from footprints_edge.errors import GroundPlaneError, MissingMapError
from footprints_edge.foundation.types import Floats, Mask
from footprints_edge.foundation.version import __version__
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.navigation.range_scan import scan


def summarise(prediction: GroundMaps) -> dict[str, Any]:
    """Sizes, ground fractions and distances, camera, model and timings, ready for JSON.

    Sizes are (height, width) in pixels, fractions refer to the picture's area, and distances are in
    metres along the optical axis. A value is null if there is no ground, or if the model file lacks
    its map. `ground_plane` is `GroundMaps.ground_plane`, which grids and drawings use as well, null
    if there is none. `nearest_obstacle_m` follows the rule of `navigation.obstacles`.
    """
    image_size, map_size = prediction.image_size, prediction.map_size
    camera = prediction.intrinsics.scaled(map_size, image_size)
    plane = None
    with suppress(GroundPlaneError, MissingMapError):
        plane = prediction.ground_plane()
    has_masks = prediction.has("ground_probability")
    obstacle_m, bearing_deg = _nearest_obstacle(prediction)
    depth_m: Floats = np.empty(0, np.float32)
    if has_masks and prediction.has("unmasked_ground_depth_m"):
        depth_m = prediction.unmasked_ground_depth_m[prediction.ground]
    pose = prediction.pose
    known = {
        "camera_height_m": pose.height_m,
        "pitch_deg": pose.pitch_deg,
        "roll_deg": pose.roll_deg,
    }
    return {
        "image": prediction.name,
        "image_size_px": list(image_size),
        "map_size_px": list(map_size),
        "ground_fraction": {
            "visible": _fraction(prediction.visible_ground) if has_masks else None,
            "hidden": _fraction(prediction.hidden_ground) if has_masks else None,
            "all": _fraction(prediction.ground) if has_masks else None,
        },
        "ground_distance_m": {
            "nearest": float(depth_m.min()) if depth_m.size else None,
            "farthest": float(depth_m.max()) if depth_m.size else None,
        },
        "ground_plane": None
        if plane is None
        else {
            "camera_height_m": plane.camera_height_m,
            "pitch_deg": plane.pitch_deg,
            "roll_deg": plane.roll_deg,
            "error_m": plane.error_m,
            "known": [name for name, value in known.items() if value is not None],
        },
        "confidence": _confidence(prediction),
        "notes": list(prediction.notes),
        "nearest_obstacle_m": obstacle_m,
        "nearest_obstacle_bearing_deg": bearing_deg,
        "robot_height_m": float(prediction.robot_height_m),
        "threshold": float(prediction.threshold),
        "camera": {
            "fx_px": camera.fx,
            "fy_px": camera.fy,
            "cx_px": camera.cx,
            "cy_px": camera.cy,
            "focal_length_px": camera.focal_px,
            "hfov_deg": camera.hfov_deg(image_size),
            "source": camera.source,
        },
        "model": {
            "name": prediction.model.name,
            "precision": prediction.model.precision,
            "sha256": prediction.model.sha256,
        },
        "versions": {"footprints_edge": __version__, "runtime": prediction.model.runtime},
        "timings_ms": {stage: round(ms, 3) for stage, ms in prediction.timings_ms.items()},
        "units": {
            "sizes": "pixels, [height, width]",
            "camera": "pixels of the upright image; (0, 0) is the centre of its top left pixel",
            "distances": "metres along the optical axis",
            "ground_plane": "degrees: pitch down, roll with the right side down; error is a median",
            "nearest_obstacle_m": "metres on the ground from the point below the camera; bearing "
            "in degrees, left positive; null: none is seen, or there is no ground plane",
            "confidence": "probabilities: that the picture shows ground, that its metres are right "
            "within a quarter; null: no ground plane, or a map is missing",
            "maps": "the npz, png16 and ply outputs have map_size_px, the overlay the image's",
        },
    }


def _confidence(prediction: GroundMaps) -> dict[str, float | None]:
    try:
        found = prediction.confidence
    except MissingMapError:
        return {"ground": None, "metres": None}
    return {
        "ground": round(found.ground, 3),
        "metres": None if math.isnan(found.metres) else round(found.metres, 3),
    }


def _nearest_obstacle(prediction: GroundMaps) -> tuple[float | None, float | None]:
    """Range in metres and bearing in degrees of the nearest obstacle in view."""
    with suppress(GroundPlaneError, MissingMapError):
        seen = scan(prediction, np.arange(-90.0, 91.0))
        ranges_m = np.where(np.isnan(seen.ranges_m), np.inf, seen.ranges_m)
        nearest = int(ranges_m.argmin())
        if np.isfinite(ranges_m[nearest]):
            return round(float(ranges_m[nearest]), 3), float(seen.bearings_deg[nearest])
    return None, None


def _fraction(mask: Mask) -> float:
    return np.count_nonzero(mask) / mask.size
