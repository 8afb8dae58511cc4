"""Check the metres of a port: plane, depth laid flat, grid, ranges and path.

Each is compared with the vector's, with room for an engine's rounding, and with what the runtime
makes of the port's own maps, with room for the rounding of floats only.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import PlanningError
from footprints_edge.foundation.types import Floats
from footprints_edge.geometry.ground_plane import GroundPlane
from footprints_edge.navigation.occupancy_grid import UNKNOWN
from footprints_edge.prediction import Prediction
from footprints_edge_export.verification.finding import Finding, iou
from footprints_edge_export.verification.test_vectors import Tolerances
from footprints_edge_export.verification.vector_metres import (
    FLAT_DEPTH,
    GRID,
    GROUND_PLANE,
    PATH,
    RANGES,
    judge_path,
    metres,
    prediction_of,
)

PLANE_KEYS = ("up", "camera_height_m", "pitch_deg", "roll_deg")

_OF_OWN = " of the port's maps"
_SAME_RANGE = 0.05
_ENDS_M = 0.02
_ROUNDED_DEG = 0.01


def is_plane(plane: Any) -> bool:  # noqa: ANN401 - JSON of a port
    """Whether it is a refusal, or a plane with numbers under all `PLANE_KEYS`."""
    try:
        if plane["refused"] is not None:
            return True
        values = [np.asarray(plane[key], np.float64) for key in PLANE_KEYS]
    except (KeyError, TypeError, ValueError):
        return False
    shapes = [value.shape for value in values]
    return shapes == [(3,), (), (), ()] and all(np.isfinite(value).all() for value in values)


def check_metres(
    found: Mapping[str, Any],
    expected: Mapping[str, Any],
    entry: Mapping[str, Any],
    threshold: float,
    allowed: Tolerances,
) -> Iterator[Finding]:
    """Compare what a port wrote for one vector.

    Args:
        found: a port's outputs by name, of the right shapes, with its maps.
        expected: the vector's.
        entry: the vector's entry in ``vectors.json``.
        threshold: probability above which a pixel is ground.
        allowed: the tolerances.
    """
    prediction = prediction_of(found["maps"], entry, threshold)
    own = _own_metres(prediction, entry)
    a = allowed
    for label, wanted, height, angle, cells, ranges in (
        ("", expected, a.plane_height, a.plane_deg, a.grid_cells, a.ranges),
        (_OF_OWN, own, a.own_plane_height, a.own_plane_deg, a.own_grid_cells, a.own_ranges),
    ):
        both = set(found) & set(wanted)
        if GROUND_PLANE in both:
            planes = found[GROUND_PLANE], wanted[GROUND_PLANE]
            yield _finding(entry, GROUND_PLANE + label, *_plane(*planes, height, angle))
        if FLAT_DEPTH in both:
            depths = found[FLAT_DEPTH], wanted[FLAT_DEPTH]
            yield _finding(entry, FLAT_DEPTH + label, *_flat_depth(*depths, bool(label), allowed))
        for name, equal, least in (
            (GRID, equal_cells, cells),
            *((name, equal_ranges, ranges) for name in RANGES),
        ):
            if name in both:
                share = equal(found[name], wanted[name])
                measured, limit = f"{100 * share:.2f} % equal", f"at least {100 * least:g} %"
                yield _finding(entry, name + label, measured, limit, share >= least)
    if PATH in found and PATH in own:
        judged = _path(prediction, found[PATH], own[PATH], entry, allowed.own_path_cost)
        yield _finding(entry, PATH + _OF_OWN, *judged)


def equal_cells(found: NDArray[Any], expected: NDArray[Any]) -> float:
    """Share of equal cells among those that are known in either grid; 1 if none is."""
    known = (found != UNKNOWN) | (expected != UNKNOWN)
    return float((found == expected)[known].mean()) if known.any() else 1.0


def equal_ranges(found: Floats, expected: Floats) -> float:
    """Share of bearings whose ranges are within 5 %, or which lack one for the same reason.

    Only bearings count at which either has a range, or at which the reasons differ; 1 if none does.
    """
    finite = np.isfinite(found) & np.isfinite(expected)
    same = (np.isposinf(found) & np.isposinf(expected)) | (np.isnan(found) & np.isnan(expected))
    counted = ~same
    same[finite] = np.abs(found[finite] / expected[finite] - 1) <= _SAME_RANGE
    return float(same[counted].mean()) if counted.any() else 1.0


def _own_metres(prediction: Prediction, entry: Mapping[str, Any]) -> dict[str, Any]:
    """What the runtime makes of the port's maps; without the path if these have none."""
    try:
        return metres(prediction, entry)
    except PlanningError:
        return metres(prediction, {**entry, "path": None})


def _plane(
    found: Mapping[str, Any], expected: Mapping[str, Any], height: float, angle: float
) -> tuple[str, str, bool]:
    if found["refused"] is not None or expected["refused"] is not None:
        reasons = found["refused"], expected["refused"]
        return f"refused: {reasons[0]}", f"refused: {reasons[1]}", reasons[0] == reasons[1]
    ups = [np.asarray(plane["up"], np.float64) for plane in (found, expected)]
    off_deg = float(np.degrees(np.arctan2(np.linalg.norm(np.cross(*ups)), np.dot(*ups))))
    off_height = abs(found["camera_height_m"] / expected["camera_height_m"] - 1)
    plane = GroundPlane(ups[0] / np.linalg.norm(ups[0]), 1.0, 0.0)
    off_angles = found["pitch_deg"] - plane.pitch_deg, found["roll_deg"] - plane.roll_deg
    consistent = max(map(abs, off_angles)) <= _ROUNDED_DEG
    return (
        f"height within {100 * off_height:.2g} %, up within {off_deg:.2g} degrees"
        + ("" if consistent else "; its pitch and roll are not those of up"),
        f"{100 * height:g} %, {angle:g} degrees",
        off_height <= height and off_deg <= angle and consistent,
    )


def _flat_depth(
    found: Floats, expected: Floats, own: bool, allowed: Tolerances
) -> tuple[str, str, bool]:
    valid = np.isfinite(found), np.isfinite(expected)
    both = valid[0] & valid[1]
    apart = np.abs(found[both] / expected[both] - 1)
    median, p99 = np.percentile(apart, [50, 99]) if apart.size else (0.0, 0.0)
    measured = f"half within {100 * median:.2g} %, 99 in 100 within {100 * p99:.2g} %"
    if not own:
        most = allowed.flat_depth_median
        return measured, f"half within {100 * most:g} %", bool(median <= most)
    most, same = allowed.own_flat_depth_p99, iou(*valid)
    return (
        f"{measured}, valid mask IoU {same:.5f}",
        f"99 in 100 within {100 * most:g} %, {allowed.own_mask_iou:g}",
        bool(p99 <= most and same >= allowed.own_mask_iou),
    )


def _path(
    prediction: Prediction,
    found_m: NDArray[np.floating],
    own_m: NDArray[np.floating],
    entry: Mapping[str, Any],
    most: float,
) -> tuple[str, str, bool]:
    """The path lies in the grid of the port's maps, and costs what the runtime's costs there."""
    judged, best = (judge_path(prediction, places_m, entry) for places_m in (found_m, own_m))
    dearer, longer = judged.cost / best.cost - 1, judged.length_m / best.length_m - 1
    return (
        f"cost {100 * dearer:+.2g} %, length {100 * longer:+.2g} %, "
        f"{judged.closed_m:.2g} m over closed cells, ends off by {judged.ends_off_m:.2g} m",
        f"{100 * most:g} %, none, {_ENDS_M:g} m",
        max(abs(dearer), abs(longer)) <= most
        and judged.closed_m <= best.closed_m + 1e-3
        and judged.ends_off_m <= _ENDS_M,
    )


def _finding(
    entry: Mapping[str, Any], quantity: str, measured: str, allowed: str, holds: bool
) -> Finding:
    return Finding(entry["name"], quantity, measured, allowed, bool(holds))
