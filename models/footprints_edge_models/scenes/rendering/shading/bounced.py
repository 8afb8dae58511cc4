"""Light that comes from the sky, and light that surfaces pass on to each other."""

from dataclasses import dataclass, field

import cv2
import numpy as np

from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.layout.scene import Lamp, Scene
from footprints_edge_models.scenes.layout.skies import sky_colours
from footprints_edge_models.scenes.rendering.geometry import Geometry
from footprints_edge_models.scenes.rendering.raycast import Floats32, Triangles
from footprints_edge_models.scenes.rendering.shading.lamps import lamp_gains, lamp_hues
from footprints_edge_models.scenes.rendering.shading.surfaces import MaterialTable
from footprints_edge_models.scenes.vectors import dot, vector

_TABLE = (32, 64)
_SEEN_LAMPS = 0.6
"""Share of the lamps' light that is not shadowed, on the mean."""
_NEAR_M = 0.6
"""Surfaces nearer to each other than this shade each other: nobody traces their shadows."""
_MOST = 3.0
"""No single ray brings more light than this: it would show as a blotch."""


@dataclass(frozen=True)
class SecondLight:
    """What a ray brings that starts at a surface: one bounce exactly, the others as a constant.

    Attributes:
        scene: The scene.
        geometry: Its triangles.
        materials: What they are made of.
        solids: Ray tracer of the triangles.
        sky: Colours of the sky by direction, float32 (3, H, W): rows from below to above.
    """

    scene: Scene
    geometry: Geometry = field(repr=False)
    materials: MaterialTable = field(repr=False)
    solids: Triangles = field(repr=False)
    sky: Floats32 = field(repr=False)

    def along(self, points: Floats32, directions: Floats32, lamps: list[Lamp]) -> Floats32:
        """Light that arrives at points (3, N) from unit directions (3, N), and what is near.

        Returns:
            (4, N): light, and in the last row how near a ray met something: 1 at once, 0 far away.
        """
        hits = self.solids.first_hits(points.T, directions.T)
        met = np.flatnonzero(hits.triangle >= 0)
        light = np.zeros_like(points) if self.scene.kind == "rooms" else self._sky(directions)
        near = np.maximum(1 - hits.distance / np.float32(_NEAR_M), 0)[None]
        if not len(met):
            return np.concatenate([light, near])
        triangle = hits.triangle[met]
        distance = hits.distance[met]
        away = np.take(directions, met, axis=1)
        normals = np.ascontiguousarray(self.geometry.normals[triangle, 0].T)
        normals *= np.where(dot(normals, away) > 0, np.float32(-1), np.float32(1))
        there = np.take(points, met, axis=1) + away * (distance * np.float32(0.998))
        material = self.geometry.material[triangle]
        albedo = np.take(self.materials.mean, material, axis=1)
        seen = albedo * self.on(there, normals, lamps) + self.materials.glow[material] * np.float32(
            0.3
        )
        seen *= np.sqrt(np.minimum(distance / np.float32(_NEAR_M), 1))
        light[:, met] = np.minimum(seen, _MOST)
        return np.concatenate([light, near])

    def on(self, points: Floats32, normals: Floats32, lamps: list[Lamp]) -> Floats32:
        """Light on surfaces that nobody looks at, with the sun's shadows but not the lamps'."""
        scene = self.scene
        light = np.zeros_like(points)
        if lamps:
            light += (lamp_hues(lamps) @ lamp_gains(lamps, points, normals)) * _SEEN_LAMPS
        if scene.kind == "rooms":
            light += vector(scene.ambient)[:, None] * np.float32(1.2)
        else:
            rise = np.float32(0.6) + np.float32(0.4) * normals[2]
            light += vector(scene.ambient)[:, None] * rise
        sun = vector(scene.sky.sun)
        towards = scene.sky.towards_sun.astype(np.float32)
        falls = np.maximum(towards @ normals, 0)
        lit = np.flatnonzero(falls > 0.02) if sun.any() else np.zeros(0, np.int64)
        if len(lit):
            start = np.take(points, lit, axis=1) + np.take(normals, lit, axis=1) * np.float32(2e-3)
            far = np.full(len(lit), 200, np.float32)
            free = ~self.solids.blocked(start.T, towards[None], far)
            light[:, lit] += sun[:, None] * (falls[lit] * free)
        return light

    def _sky(self, directions: Floats32) -> Floats32:
        rows, columns = _TABLE
        turn = np.arctan2(directions[1], directions[0]) * np.float32(columns / (2 * np.pi))
        column = (turn + np.float32(columns)).astype(np.int32) % columns
        row = ((directions[2] * np.float32(0.5) + np.float32(0.5)) * rows).astype(np.int32)
        place = np.clip(row, 0, rows - 1) * columns + column
        return np.asarray(np.take(self.sky.reshape(3, -1), place, axis=1))


def sky_table(scene: Scene, library: TextureLibrary) -> Floats32:
    """The sky's colours by direction, without the sun, for :class:`SecondLight`."""
    rows, columns = 4 * _TABLE[0], 4 * _TABLE[1]
    rise = np.repeat((np.arange(rows, dtype=np.float32) + 0.5) / rows * 2 - 1, columns)
    turn = np.tile((np.arange(columns, dtype=np.float32) + 0.5) / columns * 2 * np.pi, rows)
    flat = np.sqrt(1 - rise**2)
    directions = np.stack([flat * np.cos(turn), flat * np.sin(turn), rise], axis=1)
    colours = sky_colours(scene.sky, directions.astype(np.float32), library)
    colours = np.minimum(colours, 2 * np.mean(colours, axis=0))
    small = cv2.resize(
        colours.reshape(rows, columns, 3), _TABLE[::-1], interpolation=cv2.INTER_AREA
    )
    return np.ascontiguousarray(small.transpose(2, 0, 1))
