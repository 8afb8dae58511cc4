"""Path planning over visible and hidden ground (the paper's "Use case: Path Planning")."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import NoPathError, OffGroundError, OutsideError, PlanningError
from footprints_edge.foundation.install_hint import install_hint
from footprints_edge.foundation.types import Mask
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.geometry.ground_plane import GroundPlane
from footprints_edge.maps.ground_maps import GroundMaps

Ground: TypeAlias = Literal["all", "visible"]
Unit: TypeAlias = Literal["px", "m"]

STEP_COST = 0.01
"""Added to every pixel's cost: where probabilities round to 1, the shortest path wins."""


@dataclass(frozen=True, eq=False)
class GroundPath:
    """A path over the ground, from start to goal.

    Attributes:
        pixels: float64 (N, 2), x and y in pixels of the picture; (0, 0) is the centre of its top
            left pixel. One row for each pixel of the maps on the path.
        places_m: float64 (N, 2), the same points on the ground plane: x forward and y left, metres,
            from the point below the camera.
        hidden: bool (N,), whether the ground is hidden behind something here.
        cost: Sum over the steps: the step's length in pixels of the maps, times the mean of
            `1 - s* + STEP_COST` at its two ends.
        length_m: Length on the ground plane, metres.
    """

    pixels: NDArray[np.float64]
    places_m: NDArray[np.float64]
    hidden: Mask
    cost: float
    length_m: float

    @property
    def passes_hidden_ground(self) -> bool:
        """Whether any part of the path is hidden."""
        return bool(self.hidden.any())


def find_path(
    prediction: GroundMaps,
    start: Sequence[float],
    goal: Sequence[float],
    *,
    unit: Unit = "px",
    margin_m: float = 0.0,
    ground: Ground = "all",
) -> GroundPath:
    """Finds the cheapest path over the ground; see `Prediction.plan`."""
    if unit not in {"px", "m"}:
        raise PlanningError(f"unit is {unit!r}; give 'px' or 'm'")
    if ground not in {"all", "visible"}:
        raise PlanningError(f"ground is {ground!r}; give 'all' or 'visible'")
    if not (np.isfinite(margin_m) and margin_m >= 0):
        raise PlanningError(f"margin_m is {margin_m}; give metres, 0 or more")
    require_graph_search()
    plane = prediction.ground_plane()
    if ground == "all":
        walkable, probability = prediction.ground, prediction.ground_probability
    else:
        walkable, probability = prediction.visible_ground, prediction.visible_ground_probability
    ends = [
        _map_pixel(prediction, plane, point, unit, name)
        for name, point in (("start", start), ("goal", goal))
    ]
    safe = walkable
    if margin_m > 0:
        safe = walkable & ~_near_obstacles(walkable, plane, prediction.intrinsics, margin_m)
    for name, point, pixel in zip(("start", "goal"), (start, goal), ends, strict=True):
        where = f"the {name} {tuple(map(float, point))} {unit}"
        if not walkable[pixel]:
            raise OffGroundError(
                f"{where} is not on {'visible ' if ground == 'visible' else ''}ground (probability "
                f"{probability[pixel]:.2f}, threshold {prediction.threshold:g}); choose another "
                "point"
            )
        if not safe[pixel]:
            raise OffGroundError(
                f"{where} is closer than margin_m={margin_m:g} to an obstacle; "
                "choose another point, or a smaller margin"
            )
    route, cost = cheapest_route(np.where(safe, 1 - probability + STEP_COST, -1), ends[0], ends[1])
    if route is None:
        raise NoPathError(
            f"no path on {'visible ' if ground == 'visible' else ''}ground connects "
            f"{tuple(map(float, start))} and {tuple(map(float, goal))} {unit} "
            f"with margin_m={margin_m:g}; try a smaller margin, a lower threshold, or other points"
        )
    rows, columns = route.T
    map_px = np.stack([columns, rows], axis=1).astype(np.float64)
    places_m = plane.at_pixels(map_px, prediction.intrinsics)
    return GroundPath(
        pixels=(map_px + 0.5) / _maps_per_picture(prediction) - 0.5,
        places_m=places_m,
        hidden=prediction.hidden_ground[rows, columns],
        cost=cost,
        length_m=float(np.linalg.norm(np.diff(places_m, axis=0), axis=1).sum()),
    )


def _maps_per_picture(prediction: GroundMaps) -> NDArray[np.float64]:
    """Scale from the picture's pixels to the maps' pixels, along x and y."""
    height, width = prediction.image_size
    rows, columns = prediction.map_size
    return np.array([columns / width, rows / height])


def _map_pixel(
    prediction: GroundMaps, plane: GroundPlane, point: Sequence[float], unit: Unit, name: str
) -> tuple[int, int]:
    """Row and column in the maps of a start or goal."""
    given = np.asarray(point, np.float64)
    if given.shape != (2,) or not np.isfinite(given).all():
        raise PlanningError(f"the {name} is {point!r}; give two finite numbers")
    if unit == "m":
        map_px = plane.to_pixels(given, prediction.intrinsics)
    else:
        map_px = (given + 0.5) * _maps_per_picture(prediction) - 0.5
    rows, columns = prediction.map_size
    x, y = map_px
    if not (-0.5 <= x < columns - 0.5 and -0.5 <= y < rows - 0.5):  # NaN is outside as well
        height, width = prediction.image_size
        raise OutsideError(
            f"the {name} {tuple(map(float, point))} {unit} is outside the picture of "
            f"{width} x {height} px; choose a point in view"
        )
    return int(np.floor(y + 0.5)), int(np.floor(x + 0.5))


def _near_obstacles(
    walkable: Mask, plane: GroundPlane, intrinsics: Intrinsics, margin_m: float
) -> Mask:
    """Bool (h, w): walkable pixels closer than `margin_m` to an obstacle, on the ground plane.

    Obstacles begin at the edges between walkable and other pixels. The picture's border is not an
    obstacle.
    """
    from scipy.spatial import cKDTree

    across = np.argwhere(walkable[:, 1:] != walkable[:, :-1])[:, ::-1] + [0.5, 0.0]
    down = np.argwhere(walkable[1:] != walkable[:-1])[:, ::-1] + [0.0, 0.5]
    edges_m = plane.at_pixels(np.concatenate([across, down]), intrinsics)
    edges_m = edges_m[np.isfinite(edges_m).all(axis=1)]
    near = np.zeros_like(walkable)
    if len(edges_m):
        candidates = _candidates_near_obstacles(walkable, plane, intrinsics, margin_m)
        rows, columns = np.nonzero(candidates)
        places_m = plane.at_pixels(np.stack([columns, rows], axis=1), intrinsics)
        valid = np.isfinite(places_m).all(axis=1)
        distance_m, _ = cKDTree(edges_m).query(places_m[valid], distance_upper_bound=margin_m)
        near[rows[valid], columns[valid]] = np.isfinite(distance_m)
    return near


def _candidates_near_obstacles(
    walkable: Mask, plane: GroundPlane, intrinsics: Intrinsics, margin_m: float
) -> Mask:
    """Bool (h, w): walkable pixels that a cheap bound cannot place outside the margin.

    Points m metres apart at depth z are at most f m (1 + t) / (z - m) pixels apart along x or y,
    where t is the larger slope of the ray. This bound is far cheaper than the distance in metres.
    """
    from scipy.ndimage import distance_transform_cdt

    height, width = walkable.shape
    across = ((np.arange(width) - intrinsics.cx) / intrinsics.fx).astype(np.float32)[None, :]
    along = ((np.arange(height) - intrinsics.cy) / intrinsics.fy).astype(np.float32)[:, None]
    slope = np.maximum(np.abs(across), np.abs(along))
    focal_px = max(intrinsics.fx, intrinsics.fy)
    inverse_depth = plane.inverse_depth(intrinsics, (height, width))
    # f m (1 + t) / (z - m) with z = 1 / inverse_depth; half a pixel to the edge, half for rounding
    distance_px = distance_transform_cdt(walkable, "chessboard") - 1
    far = distance_px * (1 - margin_m * inverse_depth) > focal_px * margin_m * inverse_depth * (
        1 + slope
    )
    candidates: Mask = walkable & ~(far & (inverse_depth > 0))
    return candidates


def require_graph_search() -> None:
    """Checks that the libraries for planning are installed.

    Raises:
        PlanningError: If one is missing; the message says how to install it.
    """
    try:
        import scipy.spatial  # noqa: F401
        import skimage.graph  # noqa: F401
    except ModuleNotFoundError as error:
        raise PlanningError(
            f"planning needs the package {error.name}; {install_hint('plan')}"
        ) from None


def cheapest_route(
    costs: NDArray[np.floating], start: tuple[int, int], goal: tuple[int, int]
) -> tuple[NDArray[np.intp] | None, float]:
    """Finds the cheapest path through a grid of costs.

    Args:
        costs: (h, w), negative where no path may go.
        start: Row and column.
        goal: Row and column.

    Returns:
        Rows and columns of the path, (N, 2), and its cost; None and infinity if there is no path.
    """
    from skimage.graph import MCP_Geometric

    rows, columns = (np.flatnonzero((costs >= 0).any(axis=axis)) for axis in (1, 0))
    corner = np.array([rows[0], columns[0]])
    inside = costs[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    begin, end = (tuple((np.array(place) - corner).tolist()) for place in (start, goal))
    search = MCP_Geometric(inside)
    totals, _ = search.find_costs([begin], [end])
    if not np.isfinite(totals[end]):
        return None, float("inf")
    return np.array(search.traceback(end), np.intp) + corner, float(totals[end])
