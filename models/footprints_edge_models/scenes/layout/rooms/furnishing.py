"""Furnishes a room by its kind, then adds what any room may have."""

from collections.abc import Callable

import numpy as np

from footprints_edge_models.scenes.assets.furniture import clutter, plants, seating, storage, tables
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.people import standing
from footprints_edge_models.scenes.assets.things import box, joined
from footprints_edge_models.scenes.layout.floor_plans import Rect
from footprints_edge_models.scenes.layout.rooms.home_rooms import (
    furnish_bathroom,
    furnish_bedroom,
    furnish_dining,
    furnish_kitchen,
    furnish_living,
)
from footprints_edge_models.scenes.layout.rooms.lived_in import LIVED_IN
from footprints_edge_models.scenes.layout.rooms.room import Room
from footprints_edge_models.scenes.layout.rooms.work_rooms import (
    furnish_corridor,
    furnish_hall,
    furnish_meeting,
    furnish_office,
    furnish_store,
)

CROWDED = 0.75
"""Share of rooms with clutter on their floors."""


def furnish(palette: Palette, room: Room) -> None:
    """Fill a room with what its kind needs and what any room may have."""
    rng = palette.rng
    furnishers = FURNISHERS | LIVED_IN if palette.has_models else FURNISHERS
    furnishers[room.kind](palette, room)
    if room.kind not in {"corridor", "bathroom", "store", "seats", "shop"}:
        _line_walls(palette, room)
    _hang(palette, room)
    if rng.random() < CROWDED:
        area = room.inside.width * room.inside.depth
        for _ in range(rng.poisson(min(6.0, 0.33 * area))):
            thing = clutter.clutter(palette)
            if rng.random() < 0.6:
                room.put_at_wall(thing, rng, gap_m=float(rng.uniform(0.01, 0.15)))
            else:
                room.put_anywhere(thing, rng)
    if rng.random() < 0.25:
        for _ in range(rng.poisson(1.2)):
            room.put_anywhere(standing(palette), rng, margin_m=0.1)


def _line_walls(palette: Palette, room: Room) -> None:
    """Furniture that any room may have along its walls."""
    rng = palette.rng
    for _ in range(rng.poisson(0.13 * room.inside.width * room.inside.depth)):
        dice = rng.random()
        wide = float(rng.uniform(0.4, 1.6))
        if dice < 0.4:
            thing = storage.cabinet(palette, wide, 0.42, float(rng.uniform(0.5, 2.0)))
        elif dice < 0.6:
            thing = storage.shelf(palette, wide, 0.3, float(rng.uniform(0.8, 2.1)))
        elif dice < 0.75:
            thing = plants.plant(palette)
        elif dice < 0.87:
            thing = seating.chair(palette)
        else:
            thing = tables.table(palette, wide, 0.5, float(rng.uniform(0.5, 0.8)))
        room.put_at_wall(thing, rng)


def _hang(palette: Palette, room: Room) -> None:
    """Pictures, boards and shelves on the walls."""
    rng = palette.rng
    inside = room.inside
    for _ in range(rng.poisson(2.5)):
        wide, tall = float(rng.uniform(0.25, 1.3)), float(rng.uniform(0.25, 1.0))
        z = float(rng.uniform(1.1, 1.6))
        face = palette.of(
            "photo",
            "photo",
            "print",
            "print",
            "blank",
            "plain",
            tile_m=float(max(wide, tall) * 1.0),
        )
        parts = [box(face, (wide, 0.012, tall), (0, -0.014, z))]
        if rng.random() < 0.7:
            parts.append(
                box(
                    palette.of("wood", "plain", "blank"),
                    (wide + 0.06, 0.02, tall + 0.06),
                    (0, -0.005, z - 0.03),
                )
            )
        thing = joined("picture", parts, outlines=())
        side = int(rng.integers(4))
        across = inside.width if side % 2 == 0 else inside.depth
        if across < wide + 0.4:
            continue
        along = float(rng.uniform(0.2 + wide / 2, across - 0.2 - wide / 2))
        x, y = (
            (inside.x0 + along, inside.y1),
            (inside.x0, inside.y0 + along),
            (inside.x1 - along, inside.y0),
            (inside.x1, inside.y1 - along),
        )[side]
        place = Rect(x - wide / 2, y - wide / 2, x + wide / 2, y + wide / 2)
        if not any(place.meets(hole) for hole in room.openings):
            room.things.append(thing.at(x, y, 0.0, (0.0, np.pi / 2, np.pi, -np.pi / 2)[side]))


FURNISHERS: dict[str, Callable[[Palette, Room], None]] = {
    "bathroom": furnish_bathroom,
    "kitchen": furnish_kitchen,
    "living": furnish_living,
    "bedroom": furnish_bedroom,
    "office": furnish_office,
    "study": furnish_office,
    "meeting": furnish_meeting,
    "dining": furnish_dining,
    "corridor": furnish_corridor,
    "hall": furnish_hall,
    "store": furnish_store,
}
"""By kind of room (see :func:`interior.draw_rooms`)."""
