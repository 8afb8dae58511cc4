"""Light in worlds: lamps below ceilings indoors, and what comes through windows."""

import numpy as np

from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.things import Thing, blob, box, column, joined
from footprints_edge_models.scenes.assets.worlds import LoadedWorld
from footprints_edge_models.scenes.layout.scene import Lamp
from footprints_edge_models.scenes.layout.worlds.free_ground import FreeGround

_DOWN, _UP = (np.array([[0, 0, sign]], np.float32) for sign in (-1, 1))
_MOST_ABOVE_M = 4.5
"""Lamps of high halls hang this far above the floor."""


def hang_lamps(
    palette: Palette, world: LoadedWorld, ground: FreeGround, level_m: float
) -> tuple[list[Thing], list[Lamp]]:
    """Lamps on a grid, wherever there is floor below and a ceiling above."""
    rng = palette.rng
    corners, _ = world.floor_triangles
    low, high = corners.reshape(-1, 3)[:, :2].min(axis=0), corners.reshape(-1, 3)[:, :2].max(axis=0)
    step = float(rng.uniform(2.2, 4.2))
    counts = np.maximum(np.round((high - low) / step), 1).astype(int)
    step_x, step_y = ((high - low) / counts).tolist()
    warm = float(rng.uniform(0.0, 0.35))
    colour = np.array([1.0 + warm * 0.4, 1.0, 1.0 - warm * 0.8])
    style, shown = int(rng.integers(3)), rng.random() < 0.6
    glowing = palette.white(glow=2.5)
    things, lamps = [], []
    for index in range(int(counts.prod())):
        x = float(low[0] + (index % counts[0] + 0.5) * step_x + rng.normal(0, 0.05))
        y = float(low[1] + (index // counts[0] + 0.5) * step_y + rng.normal(0, 0.05))
        above_m = _room_above(ground, x, y, level_m)
        if above_m is None:
            continue
        hangs_m = min(above_m, _MOST_ABOVE_M)
        z = level_m + hangs_m
        if shown and hangs_m == above_m:
            part = (
                box(glowing, (0.5, 0.5, 0.03), (x, y, z - 0.04)),
                column(glowing, 0.25, 0.04, (x, y, z - 0.05)),
                blob(glowing, (0.3, 0.3, 0.2), (x, y, z - 0.22)),
            )[style]
            things.append(joined("ceiling lamp", [part], outlines=()))
        share = 3.2 * step_x * step_y / 9 * (hangs_m / 2.5) ** 2
        red, green, blue = (float(c) for c in colour * share)
        below_m = (0.1, 0.12, 0.28)[style]
        lamps.append(Lamp((x, y, z - below_m), (0.5, 0.5, 0.02), (red, green, blue)))
    return things, lamps


def _room_above(ground: FreeGround, x: float, y: float, level_m: float) -> float | None:
    """Metres from the floor to the ceiling; None if one is missing."""
    middle = np.array([[x, y, level_m + 1.6]], np.float32)
    down = float(ground.solids.first_hits(middle, _DOWN).distance[0])
    up = float(ground.solids.first_hits(middle, _UP).distance[0])
    if not (0.3 < down < 1.7 and 0.3 < up < 15):
        return None
    return 1.6 + up
