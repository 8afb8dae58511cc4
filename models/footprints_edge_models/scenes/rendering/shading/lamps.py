"""Light of lamps, shadows aside."""

import numpy as np

from footprints_edge_models.scenes.layout.scene import Lamp
from footprints_edge_models.scenes.rendering.raycast import Floats32
from footprints_edge_models.scenes.vectors import dot

MOST_LAMPS = 5
"""Those that give a picture's surfaces the most light."""


def strongest_lamps(lamps: tuple[Lamp, ...], points: Floats32) -> list[Lamp]:
    """The MOST_LAMPS that give these points the most light, shadows aside."""
    if not lamps or not points.size:
        return list(lamps[:MOST_LAMPS])
    centres = np.array([lamp.centre_m for lamp in lamps], np.float32)
    away = centres - points.T[:: max(1, points.shape[1] // 500), None]
    near = (1 / (np.einsum("pli,pli->pl", away, away) + 0.5)).mean(axis=0)
    worth = near * np.array([np.mean(lamp.power) for lamp in lamps])
    return [lamps[k] for k in np.argsort(-worth, kind="stable")[:MOST_LAMPS]]


def lamp_gains(lamps: list[Lamp], points: Floats32, normals: Floats32) -> Floats32:
    """Light of each lamp on each point without shadow, (L, N)."""
    if not lamps:
        return np.zeros((0, points.shape[1]), np.float32)
    centres = np.array([lamp.centre_m for lamp in lamps], np.float32)
    power = np.array([[np.mean(lamp.power)] for lamp in lamps], np.float32)
    square = dot(points, points) - 2 * centres @ points
    square = np.maximum(square + (centres**2).sum(axis=1)[:, None], 1e-3)
    falls = centres @ normals - dot(normals, points)
    return np.asarray(power * np.maximum(falls, 0) / ((square + 0.5) * np.sqrt(square)))


def lamp_hues(lamps: list[Lamp]) -> Floats32:
    """Colour of each lamp, (3, L): power over its mean."""
    hues = [np.array(lamp.power) / max(np.mean(lamp.power), 1e-6) for lamp in lamps]
    return np.array(hues, np.float32).T
