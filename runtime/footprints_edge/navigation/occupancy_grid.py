"""The ground in bird's-eye view: a metric occupancy grid, with queries and ROS map export."""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Literal, TypeAlias
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from footprints_edge.errors import OutputError
from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge.foundation.png import encode_png
from footprints_edge.foundation.types import Floats, Mask
from footprints_edge.geometry.camera import backproject
from footprints_edge.geometry.ground_plane import GroundPlane
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.navigation.obstacles import Obstacles, bins_of, find_obstacles

UNKNOWN, OCCUPIED, VISIBLE, HIDDEN = 0, 1, 2, 3
"""Cell values: unknown, obstacle, visible ground, hidden ground."""

MAX_CELLS = 1500
"""Most cells in the range of a grid, which has 2 * 1500 * 1500 of them then."""

_FARTHEST_M = 10_000.0

_BAND_CELLS = 2**18
"""Cells that are looked up at a time: their places take some hundred bytes each."""

_OBSTACLE_DEPTH_M = 1.0
"""In the grid of "walkable behind things", a cell without ground counts as occupied up to this
distance behind the visible surface, the depth of most furniture; farther on, such as behind walls,
it is unknown."""

HiddenAs: TypeAlias = Literal["cost", "unknown", "free"]

_UNKNOWN_LEVEL, _OCCUPIED_LEVEL, _FREE_LEVEL = 205, 0, 254  # ROS map_server's own
_HIDDEN_LEVELS: dict[HiddenAs, int] = {"cost": 147, "unknown": _UNKNOWN_LEVEL, "free": _FREE_LEVEL}
"""Grey of hidden ground. In the mode `scale`, 147 is a cost of 50, half way to occupied."""


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """An occupancy grid on the ground plane.

    Ground coordinates follow ROS REP-103: x forward, y left, metres, from the point below the
    camera. The cell at row r and column c is the square around

        x = (rows - r - 0.5) * cell_m,    y = (columns / 2 - c - 0.5) * cell_m

    so the camera is below the middle of the last row and looks towards the first row.

    Attributes:
        cells: uint8 (rows, columns): `UNKNOWN`, `OCCUPIED`, `VISIBLE` or `HIDDEN`.
        cell_m: Side of a cell, metres.
        plane: The ground plane that the grid lies in.
    """

    cells: NDArray[np.uint8]
    cell_m: float
    plane: GroundPlane

    @property
    def places_m(self) -> NDArray[np.float64]:
        """float64 (rows, columns, 2): x and y of the cells' centres."""
        rows, columns = self.cells.shape
        return _centres_m(rows, columns, self.cell_m)

    @property
    def free(self) -> Mask:
        """Bool (rows, columns): visible ground without an obstacle."""
        free: Mask = self.cells == VISIBLE
        return free

    @property
    def walkable(self) -> Mask:
        """Bool (rows, columns): ground without an obstacle, visible or hidden."""
        return self.cells >= VISIBLE

    @property
    def free_area_m2(self) -> float:
        """Area of the free cells in square metres."""
        return float(np.count_nonzero(self.free)) * self.cell_m**2

    @property
    def hidden_area_m2(self) -> float:
        """Area of the cells of hidden ground in square metres."""
        return float(np.count_nonzero(self.cells == HIDDEN)) * self.cell_m**2

    def nearest_obstacle_m(self, bearings_deg: NDArray[np.floating] | float) -> Floats:
        """Distance to the first occupied cell in each direction.

        Args:
            bearings_deg: (B,), or one number: degrees from straight ahead, left positive
                (REP-103).

        Returns:
            float32 (B,), metres from the point below the camera, accurate to half a cell; infinite
            in directions without an occupied cell, NaN for NaN.
        """
        rows, columns = self.cells.shape
        given = np.atleast_1d(np.asarray(bearings_deg, np.float64))
        bearing = np.radians(np.where(np.isfinite(given), given, 0))
        range_m = np.arange(0, np.hypot(rows, columns), 0.25) * self.cell_m
        row = np.floor(rows - np.cos(bearing)[:, None] * range_m / self.cell_m).astype(int)
        column = np.floor(columns / 2 - np.sin(bearing)[:, None] * range_m / self.cell_m)
        column = column.astype(int)
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        hit = np.zeros(row.shape, bool)
        hit[inside] = self.cells[row[inside], column[inside]] == OCCUPIED
        first = range_m[hit.argmax(axis=1)]
        nearest_m = np.where(hit.any(axis=1), first, np.inf)
        return np.where(np.isfinite(given), nearest_m, np.nan).astype(np.float32)

    def map_png(self, hidden: HiddenAs = "cost") -> bytes:
        """PNG for a ROS map server: grey 254 is free, 0 occupied, 205 unknown.

        In `cells`, up is +x and left is +y. A map server reads right as x and up as y, so the
        picture is rotated by 90 degrees: right is forward, up is left.

        Args:
            hidden: What hidden ground becomes: a `cost` half way between free and occupied,
                `unknown`, or `free`. With a cost the picture has an alpha channel, 0 in unknown
                cells, as the mode `scale` needs it.
        """
        levels = np.array(
            [_UNKNOWN_LEVEL, _OCCUPIED_LEVEL, _FREE_LEVEL, _hidden_level(hidden)], np.uint8
        )
        # rows run from far to near, columns from left to right
        cells = np.ascontiguousarray(self.cells[::-1].T)
        grey = levels[cells]
        if hidden == "cost":
            opaque = np.where(cells == UNKNOWN, np.uint8(0), np.uint8(255))
            grey = np.dstack([grey, opaque])
        return encode_png(Image.fromarray(grey))

    def map_yaml(self, image: str, hidden: HiddenAs = "cost") -> bytes:
        """YAML with which a ROS map server loads `map_png`.

        Args:
            image: File name of the PNG in the same folder.
            hidden: As for `map_png`.
        """
        _hidden_level(hidden)
        lowest_y_m = -self.cells.shape[1] / 2 * self.cell_m
        lines = [
            f"image: {json.dumps(image)}",
            f"mode: {'scale' if hidden == 'cost' else 'trinary'}",
            f"resolution: {self.cell_m:.9g}",
            f"origin: [0.0, {lowest_y_m:.9g}, 0.0]",
            "negate: 0",
            "occupied_thresh: 0.65",
            "free_thresh: 0.196",
        ]
        return ("\n".join(lines) + "\n").encode("utf-8")

    def save(
        self, yaml: str | Path, hidden: HiddenAs = "cost", *, overwrite: bool = False
    ) -> tuple[Path, Path]:
        """Writes a map for a ROS map server: the YAML, and a PNG of the same name beside it.

        Args:
            yaml: The YAML file, `.yaml` or `.yml`.
            hidden: As for `map_png`.
            overwrite: Whether to replace existing files.

        Raises:
            OutputError: If the file has another suffix, one of the two exists (nothing is written
                then), or they cannot be written.
        """
        path = Path(yaml)
        if path.suffix.lower() not in {".yaml", ".yml"}:
            raise OutputError(f"{path} is no YAML file; give map.yaml: map.png comes beside it")
        picture = path.with_suffix(".png")
        png, text = self.map_png(hidden), self.map_yaml(picture.name, hidden)
        try:
            existing = [] if overwrite else [each for each in (path, picture) if each.exists()]
            if existing:
                raise OutputError(
                    f"{existing[0]} exists; nothing was written; pass overwrite=True, or another "
                    "name"
                )
            write_atomically(picture, png)
            write_atomically(path, text)
        except (OSError, ValueError) as error:  # ValueError: a null byte in the name
            reason = getattr(error, "strerror", None) or error
            raise OutputError(f"cannot write {path}: {reason}") from error
        return path, picture


def _hidden_level(hidden: HiddenAs) -> int:
    if hidden not in _HIDDEN_LEVELS:
        raise ValueError(f"hidden is {hidden!r}; give {', '.join(map(repr, _HIDDEN_LEVELS))}")
    return _HIDDEN_LEVELS[hidden]


def make_occupancy_grid(
    prediction: GroundMaps,
    cell_m: float = 0.05,
    range_m: float = 10.0,
    robot_height_m: float | None = None,
) -> OccupancyGrid:
    """The grid of a prediction; see `Prediction.top_down`."""
    _check_sizes(cell_m, range_m)
    return grid_with(prediction, find_obstacles(prediction, robot_height_m), cell_m, range_m)


_usual_grids: WeakKeyDictionary[GroundMaps, OccupancyGrid] = WeakKeyDictionary()


def usual_grid(prediction: GroundMaps) -> OccupancyGrid:
    """The grid with the usual cells and range, made once: several output files show it."""
    grid = _usual_grids.get(prediction)
    if grid is None:
        grid = _usual_grids[prediction] = make_occupancy_grid(prediction)
    return grid


def grid_with(
    prediction: GroundMaps, obstacles: Obstacles, cell_m: float, range_m: float
) -> OccupancyGrid:
    """The grid of a prediction whose obstacles are known already."""
    plane, rows = prediction.ground_plane(), _rows(cell_m, range_m)
    cells = np.empty((rows, 2 * rows), np.uint8)
    for band in _bands(rows):
        centres = _centres(rows, float(cell_m), band.start, band.stop)
        found, row, column, seen = _ground_cells(prediction, plane, centres, range_m)
        values = found[seen]
        raised = obstacles.raised[row, column]
        values[raised] = UNKNOWN  # a table top called ground: what is beneath it is not seen
        found[seen] = values
        covered = obstacles.covers(centres.places_m, centres.bins, cell_m)
        found[covered & (centres.range_m <= range_m)] = OCCUPIED
        cells[band] = found
    return OccupancyGrid(cells, cell_m, plane)


def make_walkable_grid(
    prediction: GroundMaps, cell_m: float = 0.05, range_m: float = 10.0
) -> OccupancyGrid:
    """The grid of "walkable behind things"; see `Prediction.walkable_behind_things`."""
    _check_sizes(cell_m, range_m)
    camera, plane = prediction.intrinsics, prediction.ground_plane()
    surface = plane.to_ground(backproject(prediction.visible_depth_m, camera))
    surface_m = np.hypot(surface[..., 0], surface[..., 1])
    rows = _rows(cell_m, range_m)
    cells = np.empty((rows, 2 * rows), np.uint8)
    in_view = np.empty(cells.shape, bool)
    for band in _bands(rows):
        centres = _centres(rows, float(cell_m), band.start, band.stop)
        found, row, column, seen = _ground_cells(prediction, plane, centres, range_m)
        behind_m = centres.range_m[seen] - surface_m[row, column]
        values = found[seen]
        values[(values == UNKNOWN) & (behind_m <= _OBSTACLE_DEPTH_M)] = OCCUPIED
        found[seen] = values
        cells[band], in_view[band] = found, seen
    ground = np.pad(cells >= VISIBLE, 1)
    near_ground = np.zeros_like(in_view)
    for down, right in ((i, j) for i in range(3) for j in range(3)):
        near_ground |= ground[down : down + rows, right : right + 2 * rows]
    cells[in_view & near_ground & (cells < VISIBLE)] = OCCUPIED  # something ends the ground here
    return OccupancyGrid(cells, cell_m, plane)


def _check_sizes(cell_m: float, range_m: float) -> None:
    if not (0 < cell_m <= range_m <= min(MAX_CELLS * cell_m, _FARTHEST_M)):  # NaN is not
        raise ValueError(
            f"cell_m is {cell_m}, range_m is {range_m}; give positive numbers of metres, with "
            f"1 to {MAX_CELLS} cells in the range, which is at most {_FARTHEST_M:g} m"
        )


def _rows(cell_m: float, range_m: float) -> int:
    """The rows that reach as far as the range; 1.1 / 0.1 is a little more than 11."""
    return math.ceil(range_m / cell_m - 1e-6)


def _bands(rows: int) -> Iterator[slice]:
    """Rows of a grid to be worked on at a time, so that a large one does not fill the memory."""
    height = max(1, _BAND_CELLS // (2 * rows))
    for top in range(0, rows, height):
        yield slice(top, min(rows, top + height))


def _ground_cells(
    prediction: GroundMaps, plane: GroundPlane, centres: "_Centres", range_m: float
) -> tuple[NDArray[np.uint8], NDArray[np.intp], NDArray[np.intp], Mask]:
    """Looks up the ground below the centre of every cell.

    Args:
        prediction: Maps of all four kinds.
        plane: Their ground plane.
        centres: The cells' centres, (rows, columns).
        range_m: Cells farther from the camera are not looked up.

    Returns:
        uint8 (rows, columns): `VISIBLE`, `HIDDEN` or `UNKNOWN`; row and column in the maps of the
        cells in view; and bool (rows, columns), the cells in view.
    """
    pixels = plane.to_pixels(centres.places_m, prediction.intrinsics)
    x, y = np.moveaxis(pixels, -1, 0)
    height, width = prediction.map_size
    with np.errstate(invalid="ignore"):
        seen = (x >= -0.5) & (x < width - 0.5) & (y >= -0.5) & (y < height - 0.5)
    seen &= centres.range_m <= range_m
    row, column = np.floor(y[seen] + 0.5).astype(int), np.floor(x[seen] + 0.5).astype(int)
    values = np.full(len(row), UNKNOWN, np.uint8)
    values[prediction.ground[row, column]] = VISIBLE
    values[prediction.hidden_ground[row, column]] = HIDDEN
    cells = np.full(seen.shape, UNKNOWN, np.uint8)
    cells[seen] = values
    return cells, row, column, seen


@dataclass(frozen=True, eq=False)
class _Centres:
    """The centres of some rows of cells, (rows, columns): the same for all pictures.

    Attributes:
        places_m: float64 (rows, columns, 2): x and y.
        range_m: float64 (rows, columns): from the point below the camera.
        bins: For `Obstacles.covers`.
    """

    places_m: NDArray[np.float64]
    range_m: NDArray[np.float64]
    bins: NDArray[np.intp]


@lru_cache(maxsize=2)
def _centres(rows: int, cell_m: float, top: int, bottom: int) -> _Centres:
    """Of the rows from `top` to `bottom` of a grid; the frames of a video share them."""
    places_m = _centres_m(rows, 2 * rows, cell_m, slice(top, bottom))
    range_m = np.hypot(places_m[..., 0], places_m[..., 1])
    return _Centres(places_m, range_m, bins_of(places_m))


def _centres_m(
    rows: int, columns: int, cell_m: float, band: slice = slice(None)
) -> NDArray[np.float64]:
    """float64 (rows of the band, columns, 2): x and y of the cells' centres."""
    row = np.arange(rows)[band]
    places_m = np.empty((len(row), columns, 2))
    places_m[..., 0] = (rows - row[:, None] - 0.5) * cell_m
    places_m[..., 1] = (columns / 2 - np.arange(columns) - 0.5) * cell_m
    return places_m
