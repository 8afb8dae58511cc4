"""Cameras in a scene, and the choice of useful ones."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footprints_edge.foundation.types import Size
from footprints_edge.geometry.camera import Intrinsics, rays
from footprints_edge_models.scenes.layout.scene import Scene, SceneKind, Standpoint
from footprints_edge_models.scenes.rendering.geometry import GROUND, Geometry
from footprints_edge_models.scenes.rendering.raycast import Hits, Triangles
from footprints_edge_models.scenes.vectors import cross

CANDIDATES = 40
MOST_SHARED = 0.4
"""Share of what a camera sees that an earlier camera of the scene may show about as large."""
AIMED = 0.65
"""Share of cameras that are held towards a piece of furniture, where a room names some."""
_ALIKE = 1.6
"""Shown about as large: from distances that differ by less than this factor."""


@dataclass(frozen=True)
class Camera:
    """A camera in the world.

    Attributes:
        position_m: (3,).
        rotation: (3, 3), from camera axes (x right, y down, z forward) to the world's (z up).
        intrinsics: in pixels of its picture.
        size: (H, W) of its picture.
    """

    position_m: NDArray[np.float64]
    rotation: NDArray[np.float64]
    intrinsics: Intrinsics
    size: Size

    def rays(self, size: Size | None = None) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Origins and directions (N, 3) of the pixels of its picture, or of one of another size.

        A direction's length is such that one length is one metre along the optical axis. In memory
        they are planes, one for each of x, y and z.
        """
        size = size or self.size
        local = rays(self.intrinsics.scaled(self.size, size), size).reshape(-1, 3)
        directions = np.asfortranarray(local @ self.rotation.T.astype(np.float32))
        return np.broadcast_to(self.position_m.astype(np.float32), directions.shape), directions


def looking(heading: float, pitch_down: float, roll: float) -> NDArray[np.float64]:
    """Camera-to-world rotation; angles in radians, heading from +x anticlockwise."""
    cos, sin = np.cos(pitch_down), np.sin(pitch_down)
    forward = np.array([np.cos(heading) * cos, np.sin(heading) * cos, -sin])
    right = np.array([np.sin(heading), -np.cos(heading), 0])
    down = cross(forward, right)
    axes = np.column_stack([right, down, forward])
    cos, sin = np.cos(roll), np.sin(roll)
    turned: NDArray[np.float64] = axes @ np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    return turned


def picture_size(size: Size, rng: np.random.Generator) -> Size:
    """The size of one picture: landscape as given, 20 % portrait, 14 % square of the same area."""
    dice = rng.random()
    if dice < 0.2:
        return size[1], size[0]
    if dice < 0.34:
        side = round((size[0] * size[1]) ** 0.5 / 16) * 16
        return side, side
    return size


def choose_camera(
    scene: Scene,
    geometry: Geometry,
    size: Size,
    rng: np.random.Generator,
    solids: Triangles,
    outlines: Triangles,
    earlier: Sequence[Camera] = (),
) -> Camera | None:
    """A random camera that stands free and sees objects, not just a wall, and mostly some ground.

    A camera after the first of a scene sees other things than those before it, or the same ones
    from much nearer or farther; None where none such is found.

    Args:
        scene: the scene.
        geometry: its triangles.
        size: (H, W) of the picture.
        rng: draws the camera.
        solids: ray tracer of all triangles.
        outlines: ray tracer of the footprints on the ground.
        earlier: the scene's cameras so far.
    """
    fallback: tuple[float, Camera] | None = None
    shy = rng.random() < 0.06  # one picture in sixteen may show no ground
    wanted = int(rng.choice([0, 2, 4, 6, 9], p=[0.08, 0.17, 0.3, 0.3, 0.15]))
    around = np.random.default_rng(0).normal(size=(40, 3)).astype(np.float32)
    around /= np.linalg.norm(around, axis=1, keepdims=True)
    for _ in range(CANDIDATES):
        camera, place = _draw(scene, size, rng)
        eye = camera.position_m.astype(np.float32)
        below = np.array([[eye[0], eye[1], place.level_m - 1.0]], np.float32)
        inside = outlines.first_hits(below, np.array([[0, 0, 1]], np.float32)).distance[0] < 1.6
        near = solids.blocked(np.tile(eye, (40, 1)), around, np.full(40, 0.35, np.float32))
        if inside or near.any():
            continue
        coarse = (max(8, size[0] // 14), max(8, size[1] // 14))
        hits = solids.first_hits(*camera.rays(coarse))
        depth = np.minimum(hits.distance, 30)
        met = hits.triangle >= 0
        things = geometry.thing[hits.triangle[met]]
        seen = float((things == GROUND).sum() / met.size)
        furnishing = things[(things >= 0) & ~geometry.is_wall[hits.triangle[met]]]
        counts = np.unique(furnishing, return_counts=True)[1]
        kinds = int((counts > 2).sum())
        close = float((depth < 0.6).mean())
        quality = (
            min(seen, 0.35) + min(kinds, 8) * 0.05 + min(len(furnishing) / met.size, 0.4) - close
        )
        middle_m, far_m = (0.8, 1.6) if place.sights else (1.2, 2.2)
        open_view = (
            float(np.median(depth)) > middle_m
            and close < 0.2
            and float(np.quantile(depth, 0.9)) > far_m
        )
        if earlier and (not open_view or _shown_before(camera, coarse, hits, earlier)):
            continue
        if fallback is None or quality > fallback[0]:
            fallback = (quality, camera)
        enough = min(wanted, 2) if place.sights else wanted  # a bed fills a picture by itself
        if open_view and kinds >= enough and (shy or 0.08 < seen < 0.75):
            return camera
    if fallback is None:
        return None if earlier else _draw(scene, size, rng)[0]
    return fallback[1]


def _shown_before(camera: Camera, size: Size, hits: Hits, earlier: Sequence[Camera]) -> bool:
    """Whether an earlier camera shows much of what this one sees, about as large.

    Args:
        camera: whose picture is looked at.
        size: (H, W) of the coarse picture that was traced.
        hits: what its rays meet.
        earlier: cameras of the same scene.
    """
    met = hits.triangle >= 0
    eyes, rays_ = camera.rays(size)
    points = eyes[met] + rays_[met] * hits.distance[met, None]
    far_m = np.linalg.norm(points - camera.position_m, axis=1)
    for other in earlier:
        away = points - other.position_m
        right, down, ahead = (away @ other.rotation).T
        k, (height, width) = other.intrinsics, other.size
        ahead_m = np.maximum(ahead, 1e-3)
        x, y = k.fx * right / ahead_m + k.cx, k.fy * down / ahead_m + k.cy
        inside = (ahead > 0) & (x > 0) & (x < width) & (y > 0) & (y < height)
        factor = np.linalg.norm(away, axis=1) / np.maximum(far_m, 1e-3)
        alike = inside & (factor < _ALIKE) & (factor > 1 / _ALIKE)
        if alike.sum() > MOST_SHARED * max(len(alike), 1):
            return True
    return False


def _draw(scene: Scene, size: Size, rng: np.random.Generator) -> tuple[Camera, Standpoint]:
    weights = np.array([p.weight for p in scene.standpoints])
    place = scene.standpoints[int(rng.choice(len(weights), p=weights / weights.sum()))]
    x, y = rng.uniform(place.x0, place.x1), rng.uniform(place.y0, place.y1)
    height, pitch = _height_and_pitch(scene.kind, rng)
    if place.heights_m is not None:
        height, pitch = _height_within(place.heights_m, pitch, rng)
    if place.look_deg:
        heading = rng.choice(place.look_deg) + rng.normal(0, 35)
    elif scene.look_deg and rng.random() < 0.85:
        heading = rng.choice(scene.look_deg) + rng.normal(0, 14)
    else:
        heading = rng.uniform(-180, 180)
    if place.sights and rng.random() < AIMED:
        x, y, height, heading, pitch = _aimed(place, rng)
    roll = float(np.clip(rng.normal(0, 2), -6, 6))
    fov = float(np.clip(rng.normal(66, 13), 45, 95))
    hfov = fov if size[1] >= size[0] else max(40.0, fov * 0.72)
    z = place.level_m + height + x * scene.slope[0] + y * scene.slope[1]
    camera = Camera(
        np.array([x, y, z]),
        looking(np.radians(heading), np.radians(pitch), np.radians(roll)),
        Intrinsics.from_hfov(hfov, size),
        size,
    )
    return camera, place


def _aimed(place: Standpoint, rng: np.random.Generator) -> tuple[float, float, float, float, float]:
    """A phone held towards a piece of furniture: x, y, height, heading and pitch, in degrees."""
    area = np.array([half_m**2 for _, _, half_m, _ in place.sights])
    chosen = int(rng.choice(len(area), p=area / area.sum()))
    at_x, at_y, half_m, tall_m = place.sights[chosen]
    around, away_m = rng.uniform(-np.pi, np.pi), half_m + rng.uniform(0.6, 2.6)
    x = float(np.clip(at_x + away_m * np.cos(around), place.x0, place.x1))
    y = float(np.clip(at_y + away_m * np.sin(around), place.y0, place.y1))
    if rng.random() < 0.8:
        height = float(np.clip(rng.normal(1.45, 0.2), 0.9, 1.9))
    else:
        height = float(rng.uniform(0.4, 1.9))
    distance_m = max(0.5, float(np.hypot(at_x - x, at_y - y)))
    down = np.degrees(np.arctan2(height - tall_m * rng.uniform(0.2, 0.8), distance_m))
    heading = np.degrees(np.arctan2(at_y - y, at_x - x)) + rng.normal(0, 12)
    return x, y, height, float(heading), float(np.clip(down + rng.normal(0, 6), -10, 50))


def _height_within(
    heights_m: tuple[float, float], pitch: float, rng: np.random.Generator
) -> tuple[float, float]:
    """Half of them as phones are held, the others as robots are high, which look less down."""
    low, high = heights_m
    if rng.random() < 0.5:
        return float(np.clip(rng.normal(1.5, 0.2), low, high)), pitch
    height = float(rng.uniform(low, high))
    return height, pitch * min(1.0, 0.4 + 0.4 * height) if pitch > 0 else pitch


def _height_and_pitch(kind: SceneKind, rng: np.random.Generator) -> tuple[float, float]:
    if rng.random() < 0.2:
        return float(rng.uniform(0.5, 2.5)), float(rng.uniform(-10, 45))
    if kind == "rooms":
        return float(np.clip(rng.normal(1.5, 0.22), 0.6, 2.2)), float(
            np.clip(rng.normal(14, 11), -10, 45)
        )
    return float(np.clip(rng.normal(1.5, 0.3), 0.7, 2.5)), float(np.clip(rng.normal(4, 6), -10, 40))
