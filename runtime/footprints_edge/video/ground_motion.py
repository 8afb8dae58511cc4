"""The camera's motion between two frames, estimated from the ground that both see."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Floats, Size
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.geometry.ground_plane import GroundPlane


@dataclass(frozen=True, eq=False)
class GroundMotion:
    """The motion of the ground plane's points from this frame to the previous one.

    Attributes:
        matrix: float64 (3, 3), from rays of this frame to rays of the previous one: R + t g' with
            the camera's rotation R and translation t, and g' X = 1 on the plane. It maps a ray of
            this frame to z / z' times the ray of the previous one, where z' is the point's depth
            now and z its depth before.
        intrinsics: The camera, in pixels.
    """

    matrix: NDArray[np.float64]
    intrinsics: Intrinsics

    @classmethod
    def from_homography(
        cls, homography: NDArray[np.float64], intrinsics: Intrinsics
    ) -> "GroundMotion":
        """Builds the motion from a homography of pixels, which is defined up to a factor.

        The middle singular value of R + t g' is 1, and the ground stays in front of the camera.
        """
        K = intrinsics.matrix
        matrix = np.linalg.inv(K) @ homography @ K
        matrix /= np.linalg.svd(matrix, compute_uv=False)[1]
        return cls(matrix if np.trace(matrix) > 0 else -matrix, intrinsics)

    def before(self, size: Size) -> tuple[Floats, Floats]:
        """Previous pixel and relative depth of the ground on each ray.

        Args:
            size: (h, w) of the frames.

        Returns:
            Previous pixels (h, w, 2), x and y, NaN behind the camera; and the previous depth
            divided by the current one (h, w).
        """
        to_pixels = self.intrinsics.matrix @ self.matrix
        depth_ratio = along_rays(self.matrix[2], self.intrinsics, size)
        ahead = np.where(depth_ratio > 1e-3, depth_ratio, np.float32(np.nan))
        previous_xy = np.empty((*size, 2), np.float32)
        for axis in (0, 1):
            moved = along_rays(to_pixels[axis], self.intrinsics, size)
            np.divide(moved, ahead, out=previous_xy[..., axis])
        return previous_xy, depth_ratio

    def now_from_before(self, depth_before_m: Floats, plane: GroundPlane) -> Floats:
        """The current depth of static points, from their depth in the previous frame.

        Directions in the plane move by R alone, which gives R; the rest gives t. Then
        z = r3' ray z' + t3 with the third rows of both.

        Args:
            depth_before_m: float32 (h, w), metres, at the pixels of this frame.
            plane: The ground plane in this frame.

        Returns:
            float32 (h, w), metres; NaN behind the previous camera.
        """
        g = -plane.up / plane.camera_height_m
        along = np.cross(plane.up, np.eye(3)[np.abs(plane.up).argmin()])
        along /= np.linalg.norm(along)
        old = np.stack([along, np.cross(plane.up, along)], axis=1)
        new = self.matrix @ old
        full_old = np.column_stack([old, plane.up])
        full_new = np.column_stack([new, np.cross(new[:, 0], new[:, 1])])
        u, _, v = np.linalg.svd(full_new @ full_old.T)
        rotation = u @ v
        translation_m = (self.matrix - rotation) @ g / (g @ g)
        size = (depth_before_m.shape[0], depth_before_m.shape[1])
        turned = along_rays(rotation[2], self.intrinsics, size)
        turned[turned <= 1e-3] = np.nan
        now_m: Floats = (depth_before_m - np.float32(translation_m[2])) / turned
        return now_m


def along_rays(vector: NDArray[np.float64], intrinsics: Intrinsics, size: Size) -> Floats:
    """The product of a vector (3,) with the ray of every pixel, float32 (h, w).

    It is affine in the pixel, so all rays need not be made.
    """
    height, width = size
    across = vector[0] * (np.arange(width) - intrinsics.cx) / intrinsics.fx
    along = vector[1] * (np.arange(height) - intrinsics.cy) / intrinsics.fy + vector[2]
    product: Floats = np.add.outer(along.astype(np.float32), across.astype(np.float32))
    return product
