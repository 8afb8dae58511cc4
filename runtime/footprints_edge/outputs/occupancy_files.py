"""Occupancy grids as arrays and as points, with their axes: nobody has to rebuild them."""

import io

import numpy as np

from footprints_edge.drawing.occupancy_grid import colours_of_cells
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.navigation.occupancy_grid import UNKNOWN, usual_grid
from footprints_edge.navigation.range_scan import scan
from footprints_edge.outputs.ply import coloured_points, ply_file


def encode_occupancy_npz(prediction: GroundMaps) -> bytes:
    """Encodes the grid and the scan of a prediction as NPZ.

    `cells` uint8 (rows, columns): 0 unknown, 1 occupied, 2 visible ground, 3 hidden ground;
    `x_m` (rows,) and `y_m` (columns,), the cells' centres, metres forward and left of the point
    below the camera; `cell_m`; `plane`, the unit normal of the ground in camera axes and the
    camera's height; `bearings_deg`, `ranges_m` and `confidence` of the scan.
    """
    grid = usual_grid(prediction)
    ranges = scan(prediction, np.arange(-90.0, 91.0))
    places_m = grid.places_m
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer,
        cells=grid.cells,
        x_m=places_m[:, 0, 0],
        y_m=places_m[0, :, 1],
        cell_m=np.array(grid.cell_m),
        plane=np.append(grid.plane.up, grid.plane.camera_height_m),
        bearings_deg=ranges.bearings_deg,
        ranges_m=ranges.ranges_m,
        confidence=ranges.confidence,
    )
    return buffer.getvalue()


def encode_occupancy_ply(prediction: GroundMaps) -> bytes:
    """Encodes the known cells of the grid as points on the ground, in ground coordinates.

    Binary little-endian PLY: x forward, y left, z up, metres, from the point below the camera.
    Property `layer` is the cell's value: 1 occupied, 2 visible ground, 3 hidden ground.
    """
    grid = usual_grid(prediction)
    known = grid.cells != UNKNOWN
    places_m = grid.places_m[known]
    points_m = np.column_stack([places_m, np.zeros(len(places_m))])
    values = grid.cells[known]
    return ply_file(
        coloured_points(points_m, colours_of_cells(values, np.hypot(*places_m.T)), values),
        "metres; ground axes: x forward, y left, z up, from the point below the camera",
        "layer 1: occupied; layer 2: visible ground; layer 3: hidden ground",
    )
