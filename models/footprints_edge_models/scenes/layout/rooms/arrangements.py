"""Groups of furniture that several kinds of rooms share: tables with chairs, rugs."""

from collections.abc import Callable

import numpy as np

from footprints_edge_models.scenes.assets.furniture import seating, tables
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.people import seated_parts
from footprints_edge_models.scenes.assets.things import Patch, Thing, extended, placement, rectangle
from footprints_edge_models.scenes.layout.floor_plans import Rect
from footprints_edge_models.scenes.layout.rooms.room import Room


def lay_rug(
    palette: Palette, room: Room, x: float, y: float, width_m: float, depth_m: float
) -> None:
    """Lay a rug around a point, clipped to the room."""
    inside = room.inside.grown(-0.05)
    x0, x1 = max(x - width_m / 2, inside.x0), min(x + width_m / 2, inside.x1)
    y0, y1 = max(y - depth_m / 2, inside.y0), min(y + depth_m / 2, inside.y1)
    if x1 - x0 > 0.3 and y1 - y0 > 0.3:
        cloth = palette.of(
            "carpet", "ornament", "stripes", "checks", "fabric", tile_m=(0.4, 1.8), value=0.25
        )
        height = float(palette.rng.uniform(0.004, 0.012))
        room.rugs.append(Patch(rectangle(x0, y0, x1, y1), height, cloth))


def _seat_around(
    palette: Palette,
    room: Room,
    x: float,
    y: float,
    width_m: float,
    depth_m: float,
    make: Callable[[], Thing],
) -> None:
    """Chairs along the sides of a table, some pulled out, some turned, some taken."""
    rng = palette.rng
    for side in range(4):
        across = width_m if side % 2 == 0 else depth_m
        away = (depth_m if side % 2 == 0 else width_m) / 2
        yaw = (0.0, np.pi / 2, np.pi, -np.pi / 2)[side]
        count = int(across / 0.62)
        if rng.random() < 0.15:
            continue
        for index in range(count):
            if rng.random() < 0.2:
                continue
            along = (index + 0.5) * across / count - across / 2
            out = (
                away
                + float(rng.choice([0.0, 0.12, 0.3], p=[0.55, 0.25, 0.2]))
                + rng.normal(0, 0.03)
            )
            turn = float(rng.normal(0, 0.1 if out < away + 0.2 else 0.5))
            offset = placement(0, 0, 0, yaw)[:2, :2] @ np.array([along, out])
            thing = make()
            if rng.random() < 0.08:
                sitting = tuple(seated_parts(palette, 0.45))
                thing = extended(thing, "person", sitting)
            room.things.append(thing.at(x + offset[0], y + offset[1], 0.0, yaw + turn))


def table_group(
    palette: Palette, room: Room, width_m: float, depth_m: float, *, office: bool = False
) -> None:
    """A table with chairs somewhere in the room."""
    rng = palette.rng
    made = tables.table(palette, width_m, depth_m, float(rng.uniform(0.71, 0.77)))
    wood = palette.main_wood()
    cloth = palette.cloth() if rng.random() < 0.5 else None

    def seat() -> Thing:
        return seating.office_chair(palette) if office else seating.chair(palette, wood, cloth)

    for _ in range(10):
        x = float(rng.uniform(room.inside.x0, room.inside.x1))
        y = float(rng.uniform(room.inside.y0, room.inside.y1))
        place = Rect(x - width_m / 2, y - depth_m / 2, x + width_m / 2, y + depth_m / 2).grown(0.45)
        if room.is_free(place):
            if rng.random() < 0.3:
                lay_rug(palette, room, x, y, width_m + 1.2, depth_m + 1.2)
            room.taken.append(place)
            room.things.append(made.at(x, y))
            _seat_around(palette, room, x, y, width_m, depth_m, seat)
            return


def near_middle(room: Room, rng: np.random.Generator) -> tuple[float, float]:
    """A random point (x, y) in the middle of a room."""
    inside = room.inside
    return (
        float(inside.x0 + inside.width * rng.uniform(0.3, 0.7)),
        float(inside.y0 + inside.depth * rng.uniform(0.3, 0.7)),
    )
