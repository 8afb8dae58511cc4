"""Check a port's outputs against test vectors: what differs, where, and whether it may.

The network's maps are compared with those of the vectors, with tolerances for rounding in engines.
Masks and metres are also compared with the port's own maps, without such tolerances: a wrong
threshold or focal length cannot hide behind an engine's rounding. Plane, flat depth, grid, scan and
path likewise.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from footprints_edge.foundation.types import Floats
from footprints_edge.geometry.camera import disparity_to_depth
from footprints_edge_export.errors import ExportError
from footprints_edge_export.verification.check_metres import PLANE_KEYS, check_metres, is_plane
from footprints_edge_export.verification.finding import Finding, iou
from footprints_edge_export.verification.test_vectors import (
    FORMAT,
    MASKS,
    METRES,
    Tolerances,
    derived,
)
from footprints_edge_export.verification.vector_metres import GROUND_PLANE, NAMES, PATH

REQUIRED = ("maps", *MASKS, *METRES)
OPTIONAL = ("input", *(f"{mask}_at_image_size" for mask in MASKS), *NAMES)
"""Checked if the port writes them."""


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
            yield from check_metres(found, self.expected, self.entry, self.threshold, self.allowed)

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
        problem = self._problem(name, array)
        if problem is None:
            found[name] = array
        return problem

    def _problem(self, name: str, array: Any) -> Finding | None:  # noqa: ANN401 - an array, or JSON
        if name == GROUND_PLANE:
            keys = "refused; " + ", ".join(PLANE_KEYS)
            well = is_plane(array)
            return None if well else self._finding(name, "keys missing or no numbers", keys, False)
        shape = self.expected[name].shape
        if name == PATH and array.ndim == 2:
            shape = (len(array), 2)
        if array.shape != shape or not array.size:
            return self._finding(name, f"shape {array.shape}", f"{shape}", False)
        if name in {"maps", PATH} and not np.isfinite(array).all():
            return self._finding(name, "some are not numbers", "all finite", False)
        return None

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


def _read(path: Path) -> Any:  # noqa: ANN401 - an array, or JSON
    if path.suffix == ".json":
        return json.loads(path.read_text(encoding="utf-8"))
    if path.suffix == ".npy":
        array: NDArray[Any] = np.load(path, allow_pickle=False)
        return array
    with Image.open(path) as image:
        return np.asarray(image.convert("L")) > 127
