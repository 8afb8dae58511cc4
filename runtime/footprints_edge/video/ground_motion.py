"""The camera's motion between two frames, estimated from the ground that both see."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Floats, Size
from footprints_edge.geometry.camera import Intrinsics, rays
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
        moved = rays(self.intrinsics, size) @ self.matrix.T.astype(np.float32)
        depth_ratio: Floats = moved[..., 2]
        ahead = np.where(depth_ratio > 1e-3, depth_ratio, np.float32(np.nan))
        camera = self.intrinsics
        x = moved[..., 0] / ahead * np.float32(camera.fx) + np.float32(camera.cx)
        y = moved[..., 1] / ahead * np.float32(camera.fy) + np.float32(camera.cy)
        return np.dstack([x, y]), depth_ratio

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
        turned = rays(self.intrinsics, size) @ rotation[2].astype(np.float32)
        ahead_m: Floats = depth_before_m - np.float32(translation_m[2])
        return np.where(turned > 1e-3, ahead_m / turned, np.float32(np.nan))
