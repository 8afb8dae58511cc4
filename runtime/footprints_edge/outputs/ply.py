"""Metric point clouds as PLY files."""

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Rgb
from footprints_edge.geometry.camera import backproject
from footprints_edge.inputs.preprocessing import enough_for, preprocess
from footprints_edge.maps.ground_maps import GroundMaps

HIDDEN_GROUND_RGB = (255, 0, 200)
"""Magenta, which is rare in photos: the true colour of hidden ground is unknown."""

_PROPERTIES = (
    ("x", "float", "<f4"),
    ("y", "float", "<f4"),
    ("z", "float", "<f4"),
    ("red", "uchar", "u1"),
    ("green", "uchar", "u1"),
    ("blue", "uchar", "u1"),
    ("layer", "uchar", "u1"),
)
_VERTEX = np.dtype([(name, dtype) for name, _, dtype in _PROPERTIES])


def encode_ply(prediction: GroundMaps) -> bytes:
    """Encodes all visible surfaces, in the photo's colours, and the hidden ground.

    Binary little-endian PLY in camera axes: x right, y down, z forward, metres. Property `layer`
    is 0 for visible surfaces and 1 for hidden ground (`HIDDEN_GROUND_RGB`). There is one point per
    pixel of the maps and layer.
    """
    seen = backproject(prediction.visible_depth_m, prediction.intrinsics)
    colours = preprocess(
        prediction.picture.at_least(enough_for(prediction.map_size)), prediction.map_size
    )[0]
    ground = backproject(prediction.unmasked_ground_depth_m, prediction.intrinsics)
    hidden = ground[prediction.hidden_ground & prediction.shows_ground]
    vertices = np.concatenate(
        [
            coloured_points(seen.reshape(-1, 3), colours.reshape(-1, 3), layer=0),
            coloured_points(hidden, np.full(hidden.shape, HIDDEN_GROUND_RGB, np.uint8), layer=1),
        ]
    )
    return ply_file(
        vertices,
        "metres; camera axes: x right, y down, z forward",
        "layer 0: seen; layer 1: hidden ground",
    )


def ply_file(vertices: NDArray[np.void], *comments: str) -> bytes:
    """Encodes points as binary little-endian PLY.

    Args:
        vertices: Points from `coloured_points`.
        comments: Lines of the header, ASCII.
    """
    properties = "".join(f"property {kind} {name}\n" for name, kind, _ in _PROPERTIES)
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        + "".join(f"comment {comment}\n" for comment in comments)
        + f"element vertex {len(vertices)}\n{properties}end_header\n"
    )
    return header.encode("ascii") + vertices.tobytes()


def coloured_points(
    points_m: NDArray[np.floating], colours: Rgb, layer: int | NDArray[np.uint8]
) -> NDArray[np.void]:
    """Vertices of points (N, 3), with colours (N, 3) and a layer, one or (N,)."""
    vertices = np.empty(len(points_m), _VERTEX)
    vertices["x"], vertices["y"], vertices["z"] = points_m.T
    vertices["red"], vertices["green"], vertices["blue"] = colours.T
    vertices["layer"] = layer
    return vertices
