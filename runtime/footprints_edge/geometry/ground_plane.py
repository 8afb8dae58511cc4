"""The ground plane: its fit, the camera's pose above it, and metric coordinates on it.

Ground coordinates follow ROS REP-103: x forward, y left, z up, metres. The origin is the point of
the plane straight below the camera; forward is the viewing direction projected onto the plane.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import GroundPlaneError
from footprints_edge.foundation.types import Floats, Mask, Size
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.geometry.camera_pose import CameraPose, up_vector

# docs/porting-metres.md repeats this file in pseudo-code: what changes here changes there.

_FEWEST_PIXELS = 20
_TRIALS = 150
"""Triples drawn. If half of the pixels are inliers, at least one triple is free of outliers with
probability 1 - 1e-8."""

_FITTED = 8000
"""Maximum number of pixels for the fit, evenly drawn: three parameters need no more."""

_JUDGED = 600
"""Number of pixels that rank the hypotheses: more do not change the order."""

LEAST_AREA = 0.02
"""Share of the picture that must be ground. With less, planes fitted to an RGB-D clip were up to 45
degrees off."""

FLAT = 0.15
"""The ground is flat if the median of |ln(depth / plane's depth)| over it is at most this."""

LOWEST_M, HIGHEST_M = 0.03, 100.0
"""Camera heights between which a fitted plane is believed."""

STEEPEST_UP_DEG, MOST_LEANING_DEG = -30.0, 45.0
"""Lowest pitch, and largest lean to a side, with which a fitted plane is believed."""

_SEARCHED_DEG = np.arange(-25.0, 25.25, 0.5)
"""Angles around the fitted one among which the unknown angle is searched if the other is known."""


@dataclass(frozen=True, eq=False)
class GroundPlane:
    """The ground as one plane, in camera axes.

    Attributes:
        up: float64 (3,), the unit normal in camera axes (x right, y down, z forward).
        camera_height_m: Height of the camera above the plane, metres.
        error_m: Median distance between the plane and the ground pixels of the fit, metres:
            centimetres on flat ground, more on uneven ground or with poor depth. 0 for a plane that
            is known and not fitted.
    """

    up: NDArray[np.float64]
    camera_height_m: float
    error_m: float

    @property
    def pitch_deg(self) -> float:
        """Downward pitch of the camera in degrees: 0 looks at the horizon, 90 straight down."""
        return math.degrees(math.asin(max(-1.0, min(1.0, -float(self.up[2])))))

    @property
    def roll_deg(self) -> float:
        """Roll of the camera about its optical axis in degrees, right side down."""
        return math.degrees(math.atan2(-float(self.up[0]), -float(self.up[1])))

    @property
    def axes(self) -> NDArray[np.float64]:
        """float64 (3, 3): rows are forward, left and up, unit vectors in camera axes."""
        towards = np.array([0.0, 0.0, 1.0])
        if abs(self.up[2]) > 0.999:  # straight down: forward is up in the picture
            towards = np.array([0.0, -1.0, 0.0])
        forward = towards - (towards @ self.up) * self.up
        forward /= np.linalg.norm(forward)
        return np.stack([forward, np.cross(self.up, forward), self.up])

    def to_ground(self, points_m: NDArray[np.floating]) -> NDArray[np.float64]:
        """Converts points to ground coordinates.

        Args:
            points_m: (..., 3), metres in camera axes: x right, y down, z forward.

        Returns:
            float64 (..., 3): x forward, y left, z above the plane, metres.
        """
        moved = np.asarray(points_m @ self.axes.T, np.float64)
        moved[..., 2] += self.camera_height_m
        return moved

    def inverse_depth(self, intrinsics: Intrinsics, size: Size) -> Floats:
        """The plane's inverse depth at every pixel, which is affine in the pixel.

        Args:
            intrinsics: The camera in the pixels of `size`.
            size: (h, w).

        Returns:
            float32 (h, w), 1 / metres; not positive at and above the horizon.
        """
        height, width = size
        slope = -self.up / self.camera_height_m
        across = slope[0] * (np.arange(width) - intrinsics.cx) / intrinsics.fx
        along = slope[1] * (np.arange(height) - intrinsics.cy) / intrinsics.fy + slope[2]
        inverse_depth: Floats = np.add.outer(along.astype(np.float32), across.astype(np.float32))
        return inverse_depth

    def at_pixels(
        self, pixels: NDArray[np.floating], intrinsics: Intrinsics
    ) -> NDArray[np.float64]:
        """The points where the rays of pixels meet the plane.

        Args:
            pixels: (..., 2), x and y; (0, 0) is the centre of the top left pixel.
            intrinsics: The camera in the same pixels.

        Returns:
            float64 (..., 2): x forward and y left, metres; NaN at and above the horizon.
        """
        ray = np.ones((*pixels.shape[:-1], 3))
        ray[..., 0] = (pixels[..., 0] - intrinsics.cx) / intrinsics.fx
        ray[..., 1] = (pixels[..., 1] - intrinsics.cy) / intrinsics.fy
        forward, left, rise = np.moveaxis(ray @ self.axes.T, -1, 0)
        falling = rise < -1e-9
        stretch = np.where(falling, self.camera_height_m / np.where(falling, -rise, 1), np.nan)
        return np.stack([forward * stretch, left * stretch], axis=-1)

    def to_pixels(
        self, places_m: NDArray[np.floating], intrinsics: Intrinsics
    ) -> NDArray[np.float64]:
        """Projects points of the plane into the picture: the inverse of `at_pixels`.

        Args:
            places_m: (..., 2): x forward and y left, metres.
            intrinsics: The camera in the pixels of the result.

        Returns:
            float64 (..., 2): x and y in pixels, not clipped to the picture; NaN behind the camera.
        """
        axes = self.axes
        with np.errstate(over="ignore", invalid="ignore"):  # of places that no number holds
            points = places_m @ axes[:2] - self.camera_height_m * axes[2]
            depth_m = points[..., 2]
            ahead = depth_m > 1e-6
            scale = np.where(ahead, 1 / np.where(ahead, depth_m, 1), np.nan)
            return np.stack(
                [
                    intrinsics.cx + intrinsics.fx * points[..., 0] * scale,
                    intrinsics.cy + intrinsics.fy * points[..., 1] * scale,
                ],
                axis=-1,
            )


def find_ground_plane(
    ground_depth_m: Floats, ground: Mask, intrinsics: Intrinsics, pose: CameraPose
) -> GroundPlane:
    """The ground plane, if there is one to be believed: the one gate for everything in metres.

    A pose that is known completely gives the plane, whatever the picture shows. Otherwise it is
    fitted, and refused if less than `LEAST_AREA` of the picture is ground, if the ground is not
    `FLAT`, or if the camera's height, pitch or lean cannot be.

    Args:
        ground_depth_m: float32 (h, w), metres along the optical axis; read where `ground` is.
        ground: bool (h, w).
        intrinsics: The camera in pixels of (h, w).
        pose: What is known of the camera's pose; the rest is fitted.

    Raises:
        GroundPlaneError: If no plane fits, or the plane is refused.
    """
    if pose.height_m is not None and pose.pitch_deg is not None and pose.roll_deg is not None:
        return GroundPlane(up_vector(pose.pitch_deg, pose.roll_deg), pose.height_m, 0.0)
    plane = fit_ground_plane(ground_depth_m, ground, intrinsics, pose)
    if ground.mean() < LEAST_AREA:
        raise GroundPlaneError(
            f"{ground.mean():.1%} of the picture is ground; a plane needs {LEAST_AREA:.0%}; use a "
            "picture that shows more ground, or give the camera's height, pitch and roll",
            "little_ground",
        )
    lean_deg = math.degrees(math.asin(min(1.0, abs(float(plane.up[0])))))
    if not (
        LOWEST_M <= plane.camera_height_m <= HIGHEST_M
        and plane.pitch_deg >= STEEPEST_UP_DEG
        and (lean_deg <= MOST_LEANING_DEG or pose.roll_deg is not None)
    ):
        raise GroundPlaneError(
            f"the plane of what looks like ground cannot be the ground: the camera would be "
            f"{plane.camera_height_m:.2f} m above it, look down by {plane.pitch_deg:.0f} degrees "
            f"and lean by {lean_deg:.0f}; give the camera's height, pitch and roll, if they are so",
            "impossible_pose",
        )
    deviation = _median_deviation(plane, ground_depth_m, ground, intrinsics)
    if deviation > FLAT:
        raise GroundPlaneError(
            f"the ground is not flat: half of it deviates by more than {deviation:.0%} from one "
            "plane; use a picture of flat ground, or give the camera's height, pitch and roll",
            "not_flat",
        )
    return plane


def _median_deviation(
    plane: GroundPlane, ground_depth_m: Floats, ground: Mask, intrinsics: Intrinsics
) -> float:
    """The median of |ln(depth / plane's depth)|, relative to its own median if that is not 1.

    A camera height that is known rescales the plane, which does not make the ground uneven.
    """
    height, width = ground.shape
    chosen = _evenly_drawn(ground)
    inverse_depth = plane.inverse_depth(intrinsics, (height, width)).take(chosen)
    ratio = inverse_depth * ground_depth_m.take(chosen)
    log_ratio = np.log(np.maximum(ratio, 1e-6))
    return float(_median(np.abs(log_ratio - _median(log_ratio))))


def _evenly_drawn(ground: Mask) -> NDArray[np.intp]:
    """Indices of ground pixels, row by row: all of them, or `_FITTED`."""
    found = np.flatnonzero(ground)
    count = len(found)
    return found if count <= _FITTED else found[np.arange(_FITTED) * count // _FITTED]


def fit_ground_plane(
    ground_depth_m: Floats,
    ground: Mask,
    intrinsics: Intrinsics,
    pose: CameraPose | None = None,
) -> GroundPlane:
    """Fits the plane that at least half of the ground lies on.

    Along a plane the inverse depth is affine in the pixel, and a network's error is uniform in
    inverse depth, not in metres. So this is a least median of squares in inverse depth (Rousseeuw
    1984: no tolerance to choose, up to half of the pixels may be outliers), then least squares over
    the inliers.

    Args:
        ground_depth_m: float32 (h, w), metres along the optical axis; read where `ground` is.
        ground: bool (h, w), the pixels to fit.
        intrinsics: The camera in pixels of (h, w).
        pose: What is known of the camera's pose. It holds during the fit of the rest.

    Raises:
        GroundPlaneError: If there are too few ground pixels, they lie in one line, or their plane
            is above the camera.
    """
    width = ground.shape[1]
    count = int(np.count_nonzero(ground))
    if count < _FEWEST_PIXELS:
        raise GroundPlaneError(
            f"{count} pixels are ground; a plane needs {_FEWEST_PIXELS}; lower the threshold, or "
            "use a picture that shows more ground",
            "few_pixels",
        )
    chosen = _evenly_drawn(ground)
    rows, columns = np.divmod(chosen, width)
    directions = np.ones((3, len(chosen)))
    directions[0] = (columns - intrinsics.cx) / intrinsics.fx
    directions[1] = (rows - intrinsics.cy) / intrinsics.fy
    inverse_depth = 1 / ground_depth_m.take(chosen).astype(np.float64)
    gradient = _least_median(directions, inverse_depth)
    for _ in range(6):
        residual = np.abs(gradient @ directions - inverse_depth)
        inlier = residual <= max(2.5 * 1.4826 * float(_median(residual)), 1e-9)
        used = directions * inlier  # normal equations: 3 x 3, much faster
        gradient = np.asarray(np.linalg.pinv(used @ directions.T) @ (used @ inverse_depth))
    if pose is not None and pose.anything:
        gradient = _with_known(gradient, directions, inverse_depth, pose)
    length = float(np.linalg.norm(gradient))  # up . ray = -height / depth
    up = -gradient / length
    if up[1] > 0.2:
        raise GroundPlaneError(
            "the ground plane is above the camera; turn the picture if it is upside down",
            "above_camera",
        )
    camera_height_m = 1 / length
    above_m = up @ directions / inverse_depth + camera_height_m
    return GroundPlane(up, camera_height_m, float(_median(np.abs(above_m))))


def _with_known(
    gradient: NDArray[np.float64],
    directions: NDArray[np.float64],
    inverse_depth: NDArray[np.float64],
    pose: CameraPose,
) -> NDArray[np.float64]:
    """The gradient (3,) of inverse depth, with the known part of the pose instead of the fitted."""
    length = float(np.linalg.norm(gradient))
    fitted = GroundPlane(-gradient / length, 1 / length, 0.0)
    pitches = [fitted.pitch_deg] if pose.pitch_deg is None else [pose.pitch_deg]
    rolls = [fitted.roll_deg] if pose.roll_deg is None else [pose.roll_deg]
    if pose.pitch_deg is None and (pose.roll_deg is not None or pose.height_m is not None):
        pitches = np.clip(fitted.pitch_deg + _SEARCHED_DEG, -89, 90).tolist()
    elif pose.pitch_deg is not None and pose.roll_deg is None:
        rolls = (fitted.roll_deg + _SEARCHED_DEG).tolist()
    best, least = gradient, math.inf
    for up in (up_vector(pitch, roll) for pitch in pitches for roll in rolls):
        falling = -(up @ directions)  # height / depth
        height_m = pose.height_m
        if height_m is None:
            heights_m = (falling / inverse_depth)[falling > 0]
            height_m = float(np.median(heights_m)) if heights_m.size else 1.0
        error = float(np.median(np.abs(falling / height_m - inverse_depth)))
        if error < least:
            best, least = -up / height_m, error
    return best


def _least_median(
    directions: NDArray[np.float64], inverse_depth: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The plane (3,) through a triple with the least median |plane . direction - inverse depth|."""
    drawn = _drawn(3 * _TRIALS + _JUDGED, len(inverse_depth))
    triples, judged = drawn[: 3 * _TRIALS].reshape(_TRIALS, 3), drawn[3 * _TRIALS :]
    corners = directions.T[triples]
    usable = np.abs(np.linalg.det(corners)) > 1e-9  # collinear points span no plane
    if not usable.any():
        raise GroundPlaneError(
            f"the {len(inverse_depth)} ground pixels lie in one line, which spans no plane; "
            "use a picture that shows more ground",
            "one_line",
        )
    planes = np.linalg.solve(corners[usable], inverse_depth[triples[usable]][..., None])[..., 0]
    residual = np.abs(planes @ directions[:, judged] - inverse_depth[judged]).astype(np.float32)
    best: NDArray[np.float64] = planes[_least_middle(residual)]
    return best


def _drawn(times: int, count: int) -> NDArray[np.intp]:
    """The same numbers from 0 to count - 1 on every machine and in every language, (times,).

    They are the finaliser of MurmurHash3 (32 bits) of 0, 1, 2, ..., spread over the range.
    """
    mixed = np.arange(times, dtype=np.uint32)
    mixed ^= mixed >> 16
    mixed *= np.uint32(0x85EBCA6B)
    mixed ^= mixed >> 13
    mixed *= np.uint32(0xC2B2AE35)
    mixed ^= mixed >> 16
    return (mixed.astype(np.uint64) * np.uint64(count) >> np.uint64(32)).astype(np.intp)


def _median(values: NDArray[np.floating]) -> np.floating:
    """What `np.median` gives for one row of numbers, in half of its time."""
    middle = len(values) // 2
    ordered = np.partition(values, middle)
    upper: np.floating = ordered[middle]
    return upper if len(values) % 2 else (ordered[:middle].max() + upper) / 2


def _least_middle(residual: Floats) -> int:
    """The first row with the least middle element; `residual` is float32 (rows, n).

    A row beats a value if more than the middle number of its elements are smaller. Most rows lose
    at once, so few are ever partitioned: a sixth of the time of partitioning them all.
    """
    middle = residual.shape[1] // 2
    rows = np.arange(len(residual))
    at = 0
    while True:
        least = np.partition(residual[at], middle)[middle]
        below = np.count_nonzero(residual[rows] < least, axis=1)
        rows, below = rows[below > middle], below[below > middle]
        if not rows.size:
            break
        at = int(rows[below.argmax()])
    equal = np.count_nonzero(residual[: at + 1] <= least, axis=1) > middle
    return int(equal.argmax())
