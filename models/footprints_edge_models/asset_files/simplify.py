"""Fewer triangles for models that are finer than pictures show.

By quadric error (Garland and Heckbert, SIGGRAPH 1997), as `fast_simplification` does it.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.asset_files.asset import Surface

_FEWEST = 24
"""A surface keeps this many triangles: a box has twelve."""
_AGGRESSION = 5.0
_SAME_M = 1e-4


def simplified(surfaces: Sequence[Surface], most_triangles: int) -> tuple[Surface, ...]:
    """Surfaces of one model with about `most_triangles` triangles, if they have more.

    Each surface gives up the same share. Surfaces with holes, leaves, stay as they are.
    """
    share = most_triangles / max(sum(len(surface.triangles) for surface in surfaces), 1)
    if share >= 1:
        return tuple(surfaces)
    return tuple(_simplified(surface, share) for surface in surfaces)


def _simplified(surface: Surface, share: float) -> Surface:
    wanted = max(round(len(surface.triangles) * share), _FEWEST)
    if surface.alpha is not None or len(surface.triangles) <= wanted:
        return surface
    import fast_simplification

    surface = _welded(surface)
    if len(surface.triangles) <= wanted:
        return surface
    triangles = np.ascontiguousarray(surface.triangles, np.int32)
    old = surface.points.astype(np.float64)
    _, _, collapses = fast_simplification.simplify(
        old, triangles, target_count=wanted, agg=_AGGRESSION, return_collapses=True
    )
    points, faces, became = fast_simplification.replay_simplification(old, triangles, collapses)
    if not len(faces):
        return surface
    return replace(
        surface,
        points=points.astype(np.float32),
        triangles=faces.astype(np.int32),
        uv=_nearest(surface.uv, old, points, became),
    )


def _welded(surface: Surface) -> Surface:
    """The surface with one point for each place and place in the texture; no empty triangles."""
    rounded = np.round(surface.points / _SAME_M).astype(np.int64)
    if surface.texture is not None:
        rounded = np.column_stack([rounded, np.round(surface.uv * 4096).astype(np.int64)])
    _, first, which = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    triangles = which.reshape(-1)[surface.triangles].astype(np.int32)
    whole = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return replace(
        surface, points=surface.points[first], uv=surface.uv[first], triangles=triangles[whole]
    )


def _nearest(
    uv: NDArray[np.float32],
    old: NDArray[np.float64],
    new: NDArray[np.float64],
    became: NDArray[np.int64],
) -> NDArray[np.float32]:
    """Of each new point, the place in the texture of the nearest old point that became it."""
    away = ((old - new[became]) ** 2).sum(axis=1)
    order = np.argsort(-away, kind="stable")  # the nearest is written last
    found = np.zeros((len(new), 2), np.float32)
    found[became[order]] = uv[order]
    return found
