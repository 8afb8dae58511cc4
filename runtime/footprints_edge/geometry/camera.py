"""Pinhole cameras, and the conversion of disparity to depth and points.

Pixel (0, 0) is the centre of the top left pixel, so the centre of an image is at
((W - 1) / 2, (H - 1) / 2). Camera axes: x right, y down, z forward.
"""

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import IntrinsicsError
from footprints_edge.foundation.types import Floats, Size

IntrinsicsSource: TypeAlias = Literal["given", "rectified", "exif", "assumed"]

ASSUMED_FOV_DEG = 60.0
"""Field of view along the longer side of a picture without camera information.

Main cameras of phones see 65 to 70 degrees, webcams 55 to 70, and cropped or zoomed pictures
less than their camera: 60 is the middle. Depths scale with the focal length, so a 70 degree
picture read as 60 degrees comes out 21 % too far, a 50 degree one 19 % too near.
"""

_MOST_PX = 1e9
"""Beyond this, numbers of a camera are no pixels, and products of them have no room."""

_DIAGONAL_35MM = math.hypot(36.0, 24.0)

ArrayT = TypeVar("ArrayT", float, Floats, NDArray[np.float64])


@dataclass(frozen=True)
class Intrinsics:
    """A pinhole camera, in the pixels of one image size.

    Attributes:
        fx: Focal length along x, in pixels.
        fy: Focal length along y, in pixels.
        cx: Principal point's x, in pixels.
        cy: Principal point's y, in pixels.
        source: Where the numbers came from: `given` by the caller, of the `rectified` camera of a
            calibration file, the picture's `exif`, or `assumed`.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    source: IntrinsicsSource = "given"

    def __post_init__(self) -> None:
        """Rejects impossible values.

        Raises:
            IntrinsicsError: If a number is not finite or a focal length is not positive.
        """
        for name in ("fx", "fy", "cx", "cy"):
            try:
                value = float(getattr(self, name))
            except OverflowError:  # an integer that no float can hold
                value = math.inf
            except (TypeError, ValueError) as error:
                raise IntrinsicsError(
                    f"{name} is {getattr(self, name)!r}; give it as a finite number of pixels"
                ) from error
            if not math.isfinite(value):
                raise IntrinsicsError(f"{name} is {value}; give it as a finite number of pixels")
            object.__setattr__(self, name, value)  # a number of numpy becomes one of Python
        for name in ("fx", "fy"):
            value = getattr(self, name)
            if value <= 0:
                raise IntrinsicsError(
                    f"{name} is {value}; give the focal length as a positive number of pixels"
                )
        largest = max(self.fx, self.fy, abs(self.cx), abs(self.cy))
        if largest > _MOST_PX or min(self.fx, self.fy) < 1 / _MOST_PX:
            raise IntrinsicsError(
                f"{self} cannot be a camera; give numbers of pixels up to {_MOST_PX:g}"
            )

    @classmethod
    def from_focal_px(
        cls, focal_px: float, image_size: Size, source: IntrinsicsSource = "given"
    ) -> "Intrinsics":
        """A camera with square pixels and a centred principal point."""
        height, width = image_size
        return cls(focal_px, focal_px, (width - 1) / 2, (height - 1) / 2, source)

    @classmethod
    def from_hfov(
        cls, hfov_deg: float, image_size: Size, source: IntrinsicsSource = "given"
    ) -> "Intrinsics":
        """A camera with a horizontal field of view of `hfov_deg` degrees, from edge to edge.

        Raises:
            IntrinsicsError: If the angle is not between 0 and 180 degrees.
        """
        if not 1e-6 < hfov_deg < 180 - 1e-6:
            raise IntrinsicsError(
                f"a pinhole camera cannot have a horizontal field of view of {hfov_deg} degrees; "
                "give an angle between 0 and 180 (phones: about 65)"
            )
        focal_px = image_size[1] / 2 / math.tan(math.radians(hfov_deg) / 2)
        return cls.from_focal_px(focal_px, image_size, source)

    @classmethod
    def from_focal_35mm(
        cls, focal_mm: float, image_size: Size, source: IntrinsicsSource = "exif"
    ) -> "Intrinsics":
        """A camera from its 35 mm equivalent focal length, as EXIF states it.

        The equivalence refers to the diagonal (CIPA DCG-001): 43.27 mm of film.
        """
        focal_px = focal_mm * math.hypot(*image_size) / _DIAGONAL_35MM
        return cls.from_focal_px(focal_px, image_size, source)

    @classmethod
    def assumed(cls, image_size: Size) -> "Intrinsics":
        """A default camera: `ASSUMED_FOV_DEG` along the longer side."""
        focal_px = max(image_size) / 2 / math.tan(math.radians(ASSUMED_FOV_DEG) / 2)
        return cls.from_focal_px(focal_px, image_size, "assumed")

    @property
    def focal_px(self) -> float:
        """One focal length for both axes, in pixels: sqrt(fx fy), which preserves areas."""
        return math.sqrt(self.fx * self.fy)

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The camera matrix K, float64 (3, 3): K times a point is its pixel times its depth."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]])

    def hfov_deg(self, image_size: Size) -> float:
        """Horizontal field of view in degrees; the intrinsics must be for `image_size`."""
        return math.degrees(2 * math.atan(image_size[1] / 2 / self.fx))

    def scaled(self, from_size: Size, to_size: Size) -> "Intrinsics":
        """The same camera after its image is resized from one (H, W) to another.

        A resize maps edges to edges, so coordinates become x' = (x + 0.5) s - 0.5.
        """
        scale_y = to_size[0] / from_size[0]
        scale_x = to_size[1] / from_size[1]
        return Intrinsics(
            fx=self.fx * scale_x,
            fy=self.fy * scale_y,
            cx=(self.cx + 0.5) * scale_x - 0.5,
            cy=(self.cy + 0.5) * scale_y - 0.5,
            source=self.source,
        )


def disparity_to_depth(disparity: ArrayT, min_m: float = 0.1, max_m: float = 100.0) -> ArrayT:
    """Converts a sigmoid disparity to metres: 0 maps to `max_m`, 1 to `min_m`.

    The paper's depth parametrisation: 1 / (0.01 + 9.99 s) with the default range.

    Args:
        disparity: Any shape, in [0, 1].
        min_m: Nearest depth in metres.
        max_m: Farthest depth in metres.

    Returns:
        Depth along the optical axis in metres; same shape and dtype.
    """
    return 1.0 / (1.0 / max_m + (1.0 / min_m - 1.0 / max_m) * disparity)


def depth_to_disparity(depth_m: ArrayT, min_m: float = 0.1, max_m: float = 100.0) -> ArrayT:
    """Inverts `disparity_to_depth`; the result leaves [0, 1] for depths outside the range."""
    return (1.0 / depth_m - 1.0 / max_m) / (1.0 / min_m - 1.0 / max_m)


def rays(intrinsics: Intrinsics, size: Size) -> Floats:
    """The viewing direction of every pixel centre.

    Args:
        intrinsics: The camera in the pixels of `size`.
        size: (H, W).

    Returns:
        float32 (H, W, 3): x right, y down, z forward, with z = 1 (not unit length), so ray times
        depth is a point.
    """
    height, width = size
    directions = np.ones((height, width, 3), np.float32)
    directions[..., 0] = (np.arange(width) - intrinsics.cx) / intrinsics.fx
    directions[..., 1] = ((np.arange(height) - intrinsics.cy) / intrinsics.fy)[:, None]
    return directions


def backproject(depth_m: Floats, intrinsics: Intrinsics) -> Floats:
    """The 3D point at every pixel.

    Args:
        depth_m: float32 (H, W), metres along the optical axis; NaN stays NaN.
        intrinsics: The camera in the pixels of (H, W).

    Returns:
        float32 (H, W, 3), metres in camera axes: x right, y down, z forward.
    """
    height, width = depth_m.shape
    points: Floats = rays(intrinsics, (height, width)) * depth_m[..., None]
    return points
