"""The ground in bird's-eye view: a metric occupancy grid, with queries and ROS map export."""

import io
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from footprints_edge.errors import OutputError
from footprints_edge.foundation.types import Floats, Mask
from footprints_edge.geometry.camera import backproject
from footprints_edge.geometry.ground_plane import GroundPlane
from footprints_edge.maps.ground_maps import GroundMaps

UNKNOWN, OCCUPIED, VISIBLE, HIDDEN = 0, 1, 2, 3
"""Cell values: unknown, not ground, visible ground, hidden ground."""

MAX_CELLS = 1500
"""Most cells in the range of a grid, which has 2 * 1500 * 1500 of them then."""

_OBSTACLE_DEPTH_M = 1.0
"""A cell without ground counts as occupied up to this distance behind the visible surface, the
depth of most furniture; farther on, such as behind walls, it is unknown."""

_MAP_LEVELS = {UNKNOWN: 205, OCCUPIED: 0, VISIBLE: 254, HIDDEN: 254}  # ROS map_server's own


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
        return _centres_m(self.cells.shape[0], self.cell_m)

    @property
    def free(self) -> Mask:
        """Bool (rows, columns): ground, visible or hidden."""
        return self.cells >= VISIBLE

    @property
    def free_area_m2(self) -> float:
        """Area of all free cells in square metres."""
        return float(np.count_nonzero(self.free)) * self.cell_m**2

    @property
    def hidden_area_m2(self) -> float:
        """Area of the hidden free cells in square metres."""
        return float(np.count_nonzero(self.cells == HIDDEN)) * self.cell_m**2

    def nearest_obstacle_m(self, bearings_deg: NDArray[np.floating]) -> Floats:
        """Distance to the first occupied cell in each direction.

        Args:
            bearings_deg: (B,), degrees from straight ahead, left positive (REP-103).

        Returns:
            float32 (B,), metres from the point below the camera, accurate to half a cell; infinite
            in directions without an occupied cell.
        """
        rows, columns = self.cells.shape
        bearing = np.radians(np.asarray(bearings_deg, np.float64))
        range_m = np.arange(0, np.hypot(rows, columns), 0.25) * self.cell_m
        row = np.floor(rows - np.cos(bearing)[:, None] * range_m / self.cell_m).astype(int)
        column = np.floor(columns / 2 - np.sin(bearing)[:, None] * range_m / self.cell_m)
        column = column.astype(int)
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        hit = np.zeros(row.shape, bool)
        hit[inside] = self.cells[row[inside], column[inside]] == OCCUPIED
        first = range_m[hit.argmax(axis=1)]
        return np.where(hit.any(axis=1), first, np.inf).astype(np.float32)

    def map_png(self) -> bytes:
        """PNG for a ROS map server: grey 254 is free, 0 occupied, 205 unknown.

        In `cells`, up is +x and left is +y. A map server reads right as x and up as y, so the
        picture is rotated by 90 degrees: right is forward, up is left.
        """
        levels = np.zeros(256, np.uint8)
        for value, level in _MAP_LEVELS.items():
            levels[value] = level
        buffer = io.BytesIO()
        # rows run from far to near, columns from left to right
        Image.fromarray(np.ascontiguousarray(levels[self.cells][::-1].T)).save(buffer, "PNG")
        return buffer.getvalue()

    def map_yaml(self, image: str) -> bytes:
        """YAML with which a ROS map server loads `map_png`.

        Args:
            image: File name of the PNG in the same folder.
        """
        lowest_y_m = -self.cells.shape[1] / 2 * self.cell_m
        lines = [
            f"image: {json.dumps(image)}",
            "mode: trinary",
            f"resolution: {self.cell_m:.9g}",
            f"origin: [0.0, {lowest_y_m:.9g}, 0.0]",
            "negate: 0",
            "occupied_thresh: 0.65",
            "free_thresh: 0.196",
        ]
        return ("\n".join(lines) + "\n").encode("utf-8")

    def save(self, yaml: str | Path) -> tuple[Path, Path]:
        """Writes a map for a ROS map server: the YAML, and a PNG of the same name beside it.

        Raises:
            OutputError: If they cannot be written.
        """
        path = Path(yaml)
        picture = path.with_suffix(".png")
        try:
            picture.write_bytes(self.map_png())
            path.write_bytes(self.map_yaml(picture.name))
        except OSError as error:
            raise OutputError(f"cannot write {path}: {error.strerror or error}") from error
        return path, picture


def make_occupancy_grid(
    prediction: GroundMaps, cell_m: float = 0.05, range_m: float = 10.0
) -> OccupancyGrid:
    """The grid of a prediction; see `Prediction.top_down`."""
    if not (np.isfinite(range_m) and 0 < cell_m <= range_m <= MAX_CELLS * cell_m):
        raise ValueError(
            f"cell_m is {cell_m}, range_m is {range_m}; give positive numbers of metres, with "
            f"1 to {MAX_CELLS} cells in the range"
        )
    camera = prediction.intrinsics
    plane = prediction.ground_plane()
    rows = round(range_m / cell_m)
    columns = 2 * rows
    places_m = _centres_m(rows, cell_m)
    x, y = np.moveaxis(plane.to_pixels(places_m, camera), -1, 0)
    height, width = prediction.map_size
    with np.errstate(invalid="ignore"):
        in_view = (x >= -0.5) & (x < width - 0.5) & (y >= -0.5) & (y < height - 0.5)
    in_view &= np.hypot(places_m[..., 0], places_m[..., 1]) <= range_m
    row, column = np.floor(y[in_view] + 0.5).astype(int), np.floor(x[in_view] + 0.5).astype(int)
    surface = plane.to_ground(backproject(prediction.visible_depth_m, camera))
    surface_m = np.hypot(surface[..., 0], surface[..., 1])
    behind_m = np.hypot(*places_m[in_view].T) - surface_m[row, column]
    values = np.where(behind_m <= _OBSTACLE_DEPTH_M, OCCUPIED, UNKNOWN)
    values[prediction.ground[row, column]] = VISIBLE
    values[prediction.hidden_ground[row, column]] = HIDDEN
    cells = np.full((rows, columns), UNKNOWN, np.uint8)
    cells[in_view] = values
    free = np.pad(cells >= VISIBLE, 1)
    near_free = np.zeros_like(in_view)
    for down, right in ((i, j) for i in range(3) for j in range(3)):
        near_free |= free[down : down + rows, right : right + columns]
    cells[in_view & near_free & (cells < VISIBLE)] = OCCUPIED  # something ends the free ground here
    return OccupancyGrid(cells, cell_m, plane)


def _centres_m(rows: int, cell_m: float) -> NDArray[np.float64]:
    """float64 (rows, 2 * rows, 2): x and y of the cells' centres."""
    places_m = np.empty((rows, 2 * rows, 2))
    places_m[..., 0] = (rows - np.arange(rows)[:, None] - 0.5) * cell_m
    places_m[..., 1] = (rows - np.arange(2 * rows) - 0.5) * cell_m
    return places_m
