"""Light inside: lamps on ceilings, daylight from windows."""

import numpy as np

from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.things import Thing, blob, box, column, joined, rod
from footprints_edge_models.scenes.layout.floor_plans import Opening, Wall
from footprints_edge_models.scenes.layout.rooms.room import Room
from footprints_edge_models.scenes.layout.scene import Lamp, Sky


def window_light(wall: Wall, hole: Opening, sky: Sky) -> Lamp:
    """The daylight that comes in through a window, as a lamp."""
    middle, wide, tall = (hole.start + hole.end) / 2, hole.end - hole.start, hole.top - hole.bottom
    z = (hole.top + hole.bottom) / 2
    inner = wall.position + wall.inside * 0.2
    strength = 0.35 * wide * tall
    red, green, blue = (float(strength * c) for c in sky.horizon)
    power = (red, green, blue)
    if wall.along_x:
        return Lamp((middle, inner, z), (wide, 0.02, tall), power)
    return Lamp((inner, middle, z), (0.02, wide, tall), power)


def hang_lamps(
    palette: Palette, room: Room, height_m: float, *, on: bool
) -> tuple[list[Thing], list[Lamp]]:
    """Lamps at the ceiling."""
    rng = palette.rng
    inside = room.inside
    columns, rows = (
        max(1, round(inside.width / rng.uniform(2.5, 4.5))),
        max(1, round(inside.depth / rng.uniform(2.5, 4.5))),
    )
    warm = float(rng.uniform(0.0, 0.35))
    colour = np.array([1.0 + warm * 0.4, 1.0, 1.0 - warm * 0.8])
    style = rng.integers(4)
    things, lamps = [], []
    for index in range(columns * rows):
        x = inside.x0 + (index % columns + 0.5) * inside.width / columns
        y = inside.y0 + (index // columns + 0.5) * inside.depth / rows
        glowing = palette.white(glow=2.5 if on else 0.0)
        if style == 0:
            part, z = box(glowing, (0.6, 0.6, 0.03), (x, y, height_m - 0.03)), height_m - 0.08
        elif style == 1:
            part, z = box(glowing, (0.14, 1.2, 0.06), (x, y, height_m - 0.06)), height_m - 0.12
        elif style == 2:
            part, z = column(glowing, 0.2, 0.03, (x, y, height_m - 0.03)), height_m - 0.08
        else:
            drop = float(rng.uniform(0.3, 0.9)) if height_m > 2.6 else 0.3
            z = height_m - drop
            part = blob(glowing, (0.3, 0.3, 0.22), (x, y, z))
            things.append(
                joined(
                    "lamp cord",
                    [rod(palette.dark(), (x, y, z + 0.2), (x, y, height_m), 0.01)],
                    outlines=(),
                )
            )
            z -= 0.05
        things.append(joined("ceiling lamp", [part], outlines=()))
        if on:
            share = 3.2 * (inside.width * inside.depth / (columns * rows)) / 9
            red, green, blue = (float(c) for c in colour * share)
            lamps.append(Lamp((x, y, z), (0.5, 0.5, 0.02), (red, green, blue)))
    return things, lamps
