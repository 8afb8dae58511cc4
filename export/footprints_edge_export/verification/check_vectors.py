"""Check a port's outputs against test vectors: what differs, where, and whether it may.

The network's maps are compared with those of the vectors, with tolerances for rounding in engines.
Masks and metres are also compared with the port's own maps, without such tolerances: a wrong
threshold or focal length cannot hide behind an engine's rounding. Plane, flat depth, grid, scan and
path likewise.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from footprints_edge.errors import PlanningError
from footprints_edge.foundation.types import Floats
from footprints_edge.geometry.camera import disparity_to_depth
from footprints_edge.geometry.ground_plane import GroundPlane
from footprints_edge.navigation.occupancy_grid import UNKNOWN
from footprints_edge.prediction import Prediction
from footprints_edge_export.errors import ExportError
from footprints_edge_export.verification.test_vectors import (
    FORMAT,
    MASKS,
    METRES,
    Tolerances,
    derived,
)
from footprints_edge_export.verification.vector_metres import (
    FLAT_DEPTH,
    GRID,
    GROUND_PLANE,
    NAMES,
    PATH,
    RANGES,
    ground_plane,
    judge_path,
    metres,
    prediction_of,
)

REQUIRED = ("maps", *MASKS, *METRES)
OPTIONAL = ("input", *(f"{mask}_at_image_size" for mask in MASKS), *NAMES)
"""Checked if the port writes them."""

_SAME_RANGE = 0.05
_ENDS_M = 0.02
_PLANE_NUMBERS = ("camera_height_m", "pitch_deg", "roll_deg")


@dataclass(frozen=True)
class Finding:
    """One comparison.

    Attributes:
        vector: name of the vector.
        quantity: what was compared.
        measured: the difference, in words; or why there is none.
        allowed: the largest difference allowed, in words.
        holds: whether the difference is allowed.
        checked: whether there was anything to compare; False for what is optional and not written.
    """

    vector: str
    quantity: str
    measured: str
    allowed: str
    holds: bool
    checked: bool = True

    def __str__(self) -> str:
        """One line of a report."""
        if not self.checked:
            return f"not checked {self.vector}: {self.quantity}: {self.measured} ({self.allowed})"
        verdict = "ok     " if self.holds else "DIFFERS"
        return f"{verdict} {self.vector}: {self.quantity}: {self.measured} ({self.allowed})"


def check_vectors(vectors: Path, outputs: Path) -> list[Finding]:
    """Compare what a port wrote with the vectors.

    Args:
        vectors: folder that ``fp-export vectors`` wrote.
        outputs: folder of the port, with a sub-folder per vector and the same file names. Masks may
            be ``.png`` (0 and 255) or ``.npy`` (0 and anything else).

    Raises:
        ExportError: one of the folders does not exist, or ``vectors`` has no vectors.
    """
    manifest = read_manifest(vectors)
    if not outputs.is_dir():
        raise ExportError(f"{outputs}: no such folder of a port's outputs")
    return [
        finding
        for entry in manifest["vectors"]
        for finding in _VectorCheck(vectors, entry, manifest).findings(outputs / entry["name"])
    ]


def read_manifest(vectors: Path) -> dict[str, Any]:
    """``vectors.json`` of a folder.

    Raises:
        ExportError: there is none, or it has another format.
    """
    path = vectors / "vectors.json"
    advice = "write vectors with: fp-export vectors MODEL -o DIR"
    try:
        manifest: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ExportError(f"{path} cannot be read ({error}); {advice}") from error
    if manifest.get("format") != FORMAT:
        found = manifest.get("format")
        raise ExportError(f"{path} has format {found!r}, this version reads {FORMAT}; {advice}")
    return manifest


class _VectorCheck:
    """Comparisons of one vector."""

    def __init__(self, folder: Path, entry: dict[str, Any], manifest: dict[str, Any]) -> None:
        self.entry = entry
        self.allowed = Tolerances(**manifest["tolerances"])
        self.threshold = float(manifest["threshold"])
        self.expected = {
            name: _read(folder / file) for name, file in entry["files"].items() if name != "image"
        }

    def findings(self, outputs: Path) -> Iterator[Finding]:
        found: dict[str, Any] = {}
        for name in (name for name in (*REQUIRED, *OPTIONAL) if name in self.expected):
            problem = self._take(outputs, name, found)
            if problem is not None:
                yield problem
        if "input" in found:
            yield self._input(found["input"])
        if "maps" not in found:
            return
        yield from self._maps(found["maps"])
        own = derived(found["maps"], self.entry, self.threshold)
        for name in (name for name in found if name in own):
            if name in METRES:
                yield self._own_metres(name, found[name], own[name])
            else:
                yield self._own_mask(name, found[name] != 0, own[name] != 0)
        for channel, name in enumerate(("visible_ground", "ground")):
            if name in found:
                yield self._mask(name, channel, found[name] != 0)
        if any(name in found for name in NAMES):
            yield from self._metres(found)

    def _take(self, outputs: Path, name: str, found: dict[str, Any]) -> Finding | None:
        """Read one output into ``found``; what is wrong with it, if anything."""
        suffixes = (".json",) if name == GROUND_PLANE else (".npy", ".png")
        paths = [outputs / f"{name}{suffix}" for suffix in suffixes]
        path = next((path for path in paths if path.is_file()), None)
        if path is None:
            names = " or ".join(p.name for p in paths)
            required = name in REQUIRED
            return Finding(
                self.entry["name"], name, "not written", names, not required, checked=required
            )
        try:
            array = _read(path)
        except (OSError, ValueError) as error:
            return self._finding(name, f"cannot be read: {error}", "readable", False)
        if name == GROUND_PLANE:
            return self._take_plane(array, found)
        shape = self.expected[name].shape
        if name == PATH:
            if array.ndim != 2 or array.shape[1] != 2 or not np.isfinite(array).all():
                return self._finding(name, f"shape {array.shape}", "(N, 2), all finite", False)
            shape = array.shape
        if array.shape != shape:
            return self._finding(name, f"shape {array.shape}", f"{shape}", False)
        if array.dtype.kind == "f" and name == "maps" and not np.isfinite(array).all():
            return self._finding(name, "some are not numbers", "all finite", False)
        found[name] = array
        return None

    def _take_plane(self, plane: Any, found: dict[str, Any]) -> Finding | None:  # noqa: ANN401 - JSON
        """Checks the keys that the comparisons read."""
        try:
            if plane["refused"] is None:
                up = np.asarray(plane["up"], np.float64)
                numbers = [*up.tolist(), *(float(plane[name]) for name in _PLANE_NUMBERS)]
                if up.shape != (3,) or not np.isfinite(numbers).all():
                    raise ValueError
        except (KeyError, TypeError, ValueError):
            keys = ", ".join(("refused", "up", *_PLANE_NUMBERS))
            return self._finding(GROUND_PLANE, "keys are missing or bad", keys, False)
        found[GROUND_PLANE] = plane
        return None

    def _metres(self, found: dict[str, Any]) -> Iterator[Finding]:
        """Compare with the vector, and with what the port's own maps give."""
        prediction = prediction_of(found["maps"], self.entry, self.threshold)
        most = self.allowed
        pairs: tuple[tuple[str, dict[str, Any], tuple[float, float, float, float]], ...] = (
            ("", self.expected, (most.plane_height, most.plane_deg, most.grid_cells, most.ranges)),
            (
                " of the port's maps",
                _own_metres_of(prediction, self.entry),
                (
                    most.own_plane_height,
                    most.own_plane_deg,
                    most.own_grid_cells,
                    most.own_ranges,
                ),
            ),
        )
        for label, expected, (height, angle, cells, ranges) in pairs:
            for name in (name for name in NAMES if name in found):
                if name not in expected:
                    yield self._finding(name + label, "written", "none: no plane", False)
                elif name == GROUND_PLANE:
                    yield self._plane(found[name], expected[name], label, height, angle)
                elif name == FLAT_DEPTH:
                    yield self._flat_depth(found[name], expected[name], label)
                elif name == GRID:
                    share = equal_cells(found[name], expected[name])
                    yield self._at_least(name + label, "of known cells equal", share, cells)
                elif name in RANGES:
                    share = equal_ranges(found[name], expected[name])
                    yield self._at_least(name + label, "of bearings equal", share, ranges)
        if PATH in found and prediction_has_plane(prediction):
            yield self._path(prediction, found[PATH])

    def _plane(
        self, found: Any, expected: Any, label: str, height: float, angle: float  # noqa: ANN401 - JSON
    ) -> Finding:
        name = GROUND_PLANE + label
        if found["refused"] is not None or expected["refused"] is not None:
            refused = found["refused"], expected["refused"]
            return self._finding(
                name, f"refused: {refused[0]}", f"refused: {refused[1]}", refused[0] == refused[1]
            )
        ups = [np.asarray(plane["up"], np.float64) for plane in (found, expected)]
        off_deg = float(np.degrees(np.arctan2(np.linalg.norm(np.cross(*ups)), np.dot(*ups))))
        off_height = abs(found["camera_height_m"] / expected["camera_height_m"] - 1)
        same = all(
            abs(found[key] - value) < 0.01
            for key, value in zip(("pitch_deg", "roll_deg"), _angles(ups[0]), strict=True)
        )
        return self._finding(
            name,
            f"height within {100 * off_height:.2g} %, up within {off_deg:.2g} degrees"
            + ("" if same else "; pitch and roll are not those of up"),
            f"{100 * height:g} %, {angle:g} degrees",
            off_height <= height and off_deg <= angle and same,
        )

    def _flat_depth(self, found: Floats, expected: Floats, label: str) -> Finding:
        both = np.isfinite(found) & np.isfinite(expected)
        apart = np.abs(found[both] / expected[both] - 1)
        median, p99 = np.percentile(apart, [50, 99]) if apart.size else (0.0, 0.0)
        same = iou(np.isfinite(found), np.isfinite(expected))
        measured = f"half within {100 * median:.2g} %, 99 in 100 within {100 * p99:.2g} %"
        if label:
            limit = self.allowed.own_flat_depth_p99
            holds = p99 <= limit and same >= self.allowed.own_mask_iou
            allowed = f"99 in 100 within {100 * limit:g} %, the same ground"
        else:
            limit = self.allowed.flat_depth_median
            holds, allowed = median <= limit, f"half within {100 * limit:g} %"
        return self._finding(FLAT_DEPTH + label, measured, allowed, holds)

    def _at_least(self, name: str, what: str, share: float, least: float) -> Finding:
        return self._finding(name, f"{100 * share:.2f} % {what}", f"{100 * least:g} %", share >= least)

    def _path(self, prediction: Prediction, places_m: NDArray[np.floating]) -> Finding:
        """The path lies in the grid of the port's maps, and costs what the runtime's costs there."""
        own = _own_metres_of(prediction, self.entry).get(PATH)
        name, limit = f"{PATH} of the port's maps", self.allowed.own_path_cost
        if own is None:
            return self._finding(name, "written", "none: no path in these maps", False)
        judged = judge_path(prediction, places_m, self.entry)
        best = judge_path(prediction, own, self.entry)
        dearer, longer = judged.cost / best.cost - 1, judged.length_m / best.length_m - 1
        return self._finding(
            name,
            f"cost {100 * dearer:+.2g} %, length {100 * longer:+.2g} %, "
            f"{judged.closed_m:.2g} m over closed cells, ends off by {judged.ends_off_m:.2g} m",
            f"{100 * limit:g} %, none, {_ENDS_M:g} m",
            max(abs(dearer), abs(longer)) <= limit
            and judged.closed_m <= best.closed_m + 1e-3
            and judged.ends_off_m <= _ENDS_M,
        )

    def _input(self, found: NDArray[Any]) -> Finding:
        worst = np.abs(found.astype(int) - self.expected["input"].astype(int)).max()
        limit = self.allowed.input_levels
        return self._finding("input", f"{worst} levels", f"at most {limit}", worst <= limit)

    def _maps(self, found: Floats) -> Iterator[Finding]:
        maps = self.expected["maps"]
        most = self.allowed
        for channel in (0, 1):
            apart = np.abs(found[0, channel] - maps[0, channel])
            mean, worst = apart.mean(), apart.max()
            yield self._finding(
                f"maps[{channel}]",
                f"mean {mean:.2g}, largest {worst:.2g}",
                f"at most {most.probability_mean:g} and {most.probability_max:g}",
                mean <= most.probability_mean and worst <= most.probability_max,
            )
        for channel in (2, 3):
            depths = [disparity_to_depth(m[0, channel]) for m in (found, maps)]
            median, p99 = np.percentile(np.abs(depths[0] / depths[1] - 1), [50, 99])
            yield self._finding(
                f"maps[{channel}] as depth",
                f"half within {100 * median:.2g} %, 99 in 100 within {100 * p99:.2g} %",
                f"at most {100 * most.depth_median:g} % and {100 * most.depth_p99:g} %",
                median <= most.depth_median and p99 <= most.depth_p99,
            )

    def _mask(self, name: str, channel: int, found: NDArray[np.bool_]) -> Finding:
        """Compare with the vector where it is far from the threshold; also report plain IoU."""
        expected = self.expected[name] != 0
        distance = np.abs(self.expected["maps"][0, channel] - self.threshold)
        is_sure = distance >= self.allowed.mask_margin
        plain, sure = iou(found, expected), iou(found & is_sure, expected & is_sure)
        return self._finding(
            name,
            f"IoU {sure:.5f} where the vector is sure, {plain:.5f} everywhere",
            f"at least {self.allowed.mask_iou:g} where {self.allowed.mask_margin:g} from threshold",
            sure >= self.allowed.mask_iou,
        )

    def _own_mask(self, name: str, found: NDArray[np.bool_], own: NDArray[np.bool_]) -> Finding:
        at_image_size = name.endswith("_at_image_size")
        limits = self.allowed.own_mask_iou, self.allowed.own_mask_iou_at_image_size
        limit, value = limits[at_image_size], iou(found, own)
        label = f"{name} of the port's maps"
        return self._finding(label, f"IoU {value:.5f}", f"at least {limit:g}", value >= limit)

    def _own_metres(self, name: str, found: Floats, own: Floats) -> Finding:
        label = f"{name} of the port's maps"
        valid = np.isfinite(own)
        same = iou(valid, np.isfinite(found))
        both = valid & np.isfinite(found)
        worst = float(np.abs(found[both] / own[both] - 1).max(initial=0))
        return self._finding(
            label,
            f"within {100 * worst:.2g} %, valid mask IoU {same:.5f}",
            f"{100 * self.allowed.own_metres:g} %, {self.allowed.own_mask_iou:g}",
            worst <= self.allowed.own_metres and same >= self.allowed.own_mask_iou,
        )

    def _finding(self, quantity: str, measured: str, allowed: str, holds: bool) -> Finding:
        return Finding(self.entry["name"], quantity, measured, allowed, bool(holds))


def prediction_has_plane(prediction: Prediction) -> bool:
    """Whether the maps have a ground plane."""
    return ground_plane(prediction)["refused"] is None


def _own_metres_of(prediction: Prediction, entry: dict[str, Any]) -> dict[str, Any]:
    """The metres of a port's maps; without the path where these have none."""
    try:
        return metres(prediction, entry)
    except PlanningError:
        return metres(prediction, {**entry, "path": None})


def _angles(up: NDArray[np.float64]) -> tuple[float, float]:
    plane = GroundPlane(up / np.linalg.norm(up), 1.0, 0.0)
    return plane.pitch_deg, plane.roll_deg


def equal_cells(found: NDArray[Any], expected: NDArray[Any]) -> float:
    """Share of equal cells among those that are known in either grid; 1 if none is."""
    known = (found != UNKNOWN) | (expected != UNKNOWN)
    return float((found == expected)[known].mean()) if known.any() else 1.0


def equal_ranges(found: Floats, expected: Floats) -> float:
    """Share of bearings with the same range, within 5 %, or both without one, or not in view."""
    both = np.isfinite(found) & np.isfinite(expected)
    same = (np.isposinf(found) & np.isposinf(expected)) | (np.isnan(found) & np.isnan(expected))
    same[both] = np.abs(found[both] / expected[both] - 1) <= _SAME_RANGE
    return float(same.mean())


def iou(a: NDArray[np.bool_], b: NDArray[np.bool_]) -> float:
    """Intersection over union of two masks; 1 where both are empty."""
    union = int((a | b).sum())
    return float((a & b).sum() / union) if union else 1.0


def _read(path: Path) -> Any:  # noqa: ANN401 - an array, or JSON
    if path.suffix == ".json":
        return json.loads(path.read_text(encoding="utf-8"))
    if path.suffix == ".npy":
        array: NDArray[Any] = np.load(path, allow_pickle=False)
        return array
    with Image.open(path) as image:
        return np.asarray(image.convert("L")) > 127
