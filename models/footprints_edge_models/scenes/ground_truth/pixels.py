"""Exact ground truth per pixel: S, D, S* and D* of the paper, and why there is no ground."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.asset_files.world_plan import STOREY_M
from footprints_edge_models.scenes.rendering.cameras import Camera
from footprints_edge_models.scenes.rendering.geometry import GROUND, Geometry
from footprints_edge_models.scenes.rendering.raycast import Triangles

VISIBLE_GROUND, GROUND_ANYWHERE, FOOTPRINT, BEHIND_WALL = 1, 2, 4, 8
"""Bits of a pixel's label: S; S*; the ground on the ray is an object's footprint; a wall or a
building stands between the camera and the ground on the ray."""


@dataclass(frozen=True)
class SceneGroundTruth:
    """The ground truth of a photo, all of its (H, W).

    Attributes:
        bits: uint8, a combination of VISIBLE_GROUND and its companions.
        visible_depth_m: float32, metres along the optical axis to what is seen, 0 for the sky.
        ground_depth_m: float32, to the ground on the ray with everything else removed, footprints
            included; 0 where the ray meets no ground.
    """

    bits: NDArray[np.uint8] = field(repr=False)
    visible_depth_m: NDArray[np.float32] = field(repr=False)
    ground_depth_m: NDArray[np.float32] = field(repr=False)


def trace_ground_truth(
    camera: Camera, geometry: Geometry, solids: Triangles, outlines: Triangles
) -> SceneGroundTruth:
    """Trace the ray of every pixel to its first hit, and to the ground.

    S* holds where the first hit with the ground, everything else removed, lies in no footprint. S
    holds where that is also the first hit with anything.
    """
    origins, directions = camera.rays()
    seen = solids.first_hits(origins, directions)
    met_any = seen.triangle >= 0
    is_seen = met_any & (geometry.thing[seen.triangle] == GROUND)
    if geometry.storeys:  # the floor above is no ground from below
        is_seen &= _from_above(directions, geometry.normals[seen.triangle, 0])
    depth_m = np.where(is_seen, seen.distance, 0).astype(np.float32)
    # visible ground is the first hit with the ground, too: only the other rays are traced
    rest = np.flatnonzero(~is_seen)
    found = geometry.ground_alone.first_hits(origins[rest], np.take(directions.T, rest, axis=1).T)
    found_any = found.triangle >= 0
    if geometry.storeys:
        number = np.flatnonzero(geometry.thing < 0)[found.triangle]
        found_any &= geometry.thing[number] == GROUND  # not the side of a kerb
        found_any &= _from_above(directions[rest], geometry.normals[number, 0])
    depth_m[rest] = np.where(found_any, found.distance, 0)
    met = is_seen.copy()
    met[rest] = found_any
    grounded = np.flatnonzero(met)
    below = origins[grounded].T + np.take(directions.T, grounded, axis=1) * depth_m[grounded]
    far = np.full(len(grounded), 1e37, np.float32)
    if geometry.storeys:
        below[2] -= STOREY_M
        far[:] = 2 * STOREY_M
    else:
        below[2] = -1
    taken = np.zeros_like(met)
    up = np.array([[0, 0, 1]], np.float32)
    taken[grounded] = outlines.blocked(below.T, up, far)
    hidden = np.flatnonzero(met & ~is_seen)
    behind_wall = np.zeros_like(met)
    behind_wall[hidden] = geometry.walls_alone.blocked(
        origins[hidden], directions[hidden], depth_m[hidden] - 1e-3
    )
    bits = np.zeros(met.shape, np.uint8)
    bits[is_seen & ~taken] |= VISIBLE_GROUND
    bits[met & ~taken] |= GROUND_ANYWHERE
    bits[taken] |= FOOTPRINT
    bits[behind_wall] |= BEHIND_WALL
    visible_m = np.where(met_any, seen.distance, 0).astype(np.float32)
    shape = camera.size
    return SceneGroundTruth(bits.reshape(shape), visible_m.reshape(shape), depth_m.reshape(shape))


def _from_above(directions: NDArray[np.float32], normals: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Whether rays (N, 3) meet ground from above; low edges of floors have normals (N, 3) aside."""
    aside = np.abs(normals[:, 2]) < 0.7
    return np.asarray((np.einsum("ij,ij->i", directions, normals) < 0) | aside)
